// libFuzzer target of the JSON that comes otherwise than over HTTP: the first byte of an input says by which door, the
// rest is the document, which is mutated as one.
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <string_view>

#include "base/fuzz/json_mutator.hpp"
#include "server/fuzz/json_doors.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using subpixel::server::JsonDoors;

constexpr std::array<std::string_view, 10> kWords{"",   "noaa", "msaa:samples=4|8",        "all",        "streaming_*",
                                                  "..", "done", "dcaa:samples=64:merge=x", "frame0.png", "\xc3\xa4"};

const std::vector<std::string>& examples_of(std::uint8_t byte) {
  return JsonDoors::examples()[byte % JsonDoors::examples().size()];
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed) {
  std::minstd_rand random(seed + 1);
  if (size < 1 || random() % 8 == 0) return LLVMFuzzerMutate(data, size, most);
  std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::vector<std::string>& examples = examples_of(data[0]);
  if (random() % 64 == 0) text = examples[random() % examples.size()];
  const std::string made = subpixel::mutated_json(text, kWords, random);
  if (made.empty() || made.size() + 1 > most) return LLVMFuzzerMutate(data, size, most);
  std::memcpy(data + 1, made.data(), made.size());
  return made.size() + 1;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("subpixel-fuzz-" + std::to_string(::getpid()));
  static JsonDoors doors(folder);
  if (size == 0) return 0;
  doors.take(data[0] % JsonDoors::examples().size(), {reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
