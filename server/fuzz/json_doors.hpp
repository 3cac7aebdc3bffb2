// The JSON that others hand the service besides bodies of requests: nights' configurations, and all that a worker
// says, which may be what a hostile capture made of it. For fuzzers and tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::server {

class JsonDoors {
 public:
  explicit JsonDoors(const std::filesystem::path& folder);
  ~JsonDoors();

  // Of each door some documents that it takes.
  static const std::vector<std::vector<std::string>>& examples();
  enum class Outcome { taken, refused };
  // Hands `text` to door `which` (below examples().size()). Anything but an Error for bad input, and what was taken and
  // does not come out again as it was stored, is thrown on.
  Outcome take(std::size_t which, std::string_view text);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace subpixel::server
