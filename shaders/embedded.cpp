#include "shaders/embedded.hpp"

#include <vector>

namespace subpixel::shaders {

std::span<const Embedded> all() {
  static const std::vector<Embedded> table = [] {
    const auto replay = replay_shaders();
    std::vector<Embedded> both(replay.begin(), replay.end());
    if (test_shaders) {
      const auto test = test_shaders();
      both.insert(both.end(), test.begin(), test.end());
    }
    return both;
  }();
  return table;
}

}  // namespace subpixel::shaders
