#include "replay/reference/turns.hpp"

#include <bit>

namespace subpixel::replay {
namespace {

// Van der Corput's radical inverse in base 2.
double radical_inverse(std::uint32_t value) {
  double result = 0, digit = 0.5;
  for (; value != 0; value >>= 1, digit /= 2)
    if (value & 1) result += digit;
  return result;
}

std::uint32_t parity(std::uint32_t bits) {
  return static_cast<std::uint32_t>(std::popcount(bits)) & 1;
}

}  // namespace

std::uint32_t shaded_sample(std::uint32_t turn, std::uint32_t turns) {
  const std::uint32_t right = parity(turn & 0x55555555), below = parity(turn & 0xaaaaaaaa);
  // Of an odd number of bits the highest chooses both: right comes from the lowest one on, below up to the highest.
  const int bits = std::bit_width(turns - 1);
  const std::uint32_t highest = bits % 2 == 1 ? turn >> (bits - 1) & 1 : 0;
  return right | (below ^ highest) << 1;
}

std::vector<gpu_types::TurnConstants> turn_constants(std::uint32_t turns, std::uint32_t width, std::uint32_t height) {
  std::vector<gpu_types::TurnConstants> all;
  for (std::uint32_t i = 0; i < turns; ++i) {
    const glm::dvec2 shift((i + 0.5) / turns - 0.5, radical_inverse(i) + 0.5 / turns - 0.5);  // quarters of a pixel
    const glm::dvec2 pixels = shift / 2.0;
    all.push_back(
        {glm::vec4(pixels, 2.0 * pixels / glm::dvec2(width, height)), {i, turns, shaded_sample(i, turns), i / 4 % 3}});
  }
  return all;
}

glm::vec2 sample_place(const gpu_types::TurnConstants& turn, std::uint32_t s) {
  return glm::vec2(0.25f) + 0.5f * glm::vec2(s & 1, s >> 1) - glm::vec2(turn.shift);
}

}  // namespace subpixel::replay
