// libFuzzer target of all that clients send: the first byte says whether callers must have a token, the rest is what
// comes over one connection.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "server/fuzz/http_door.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using subpixel::server::HttpDoor;

// A store that many runs have been added to is slow; a new one stands for it.
constexpr int kMessagesForEachFolder = 20'000;

class Doors {
 public:
  HttpDoor& door(bool with_token) {
    if (taken_++ % kMessagesForEachFolder == 0) renew();
    return with_token ? *guarded_ : *open_;
  }
  ~Doors() { remove(); }

 private:
  void remove() {
    open_.reset();
    guarded_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void renew() {
    remove();
    open_ = std::make_unique<HttpDoor>(folder_ / "open", false);
    guarded_ = std::make_unique<HttpDoor>(folder_ / "guarded", true);
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("subpixel-fuzz-" + std::to_string(::getpid()));
  std::unique_ptr<HttpDoor> open_, guarded_;
  int taken_ = 0;
};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed) {
  if (size < 1 || most < 2 || seed % 4 == 0) return LLVMFuzzerMutate(data, size, most);
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::string made = subpixel::server::mutated_requests(text, most - 1, seed);
  std::memcpy(data + 1, made.data(), made.size());
  return made.size() + 1;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Doors doors;
  if (size == 0) return 0;
  HttpDoor& door = doors.door(data[0] % 2 == 1);
  const std::string wrong = door.take({reinterpret_cast<const char*>(data) + 1, size - 1}).wrong;
  if (!wrong.empty()) {
    std::fprintf(stderr, "%s\n", wrong.c_str());
    std::abort();
  }
  return 0;
}
