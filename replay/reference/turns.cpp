#include "replay/reference/turns.hpp"

namespace subpixel::replay {
namespace {

// Van der Corput's radical inverse in base 2.
double radical_inverse(std::uint32_t value) {
  double result = 0, digit = 0.5;
  for (; value != 0; value >>= 1, digit /= 2)
    if (value & 1) result += digit;
  return result;
}

}  // namespace

std::vector<gpu_types::TurnConstants> turn_constants(std::uint32_t turns, std::uint32_t width, std::uint32_t height) {
  std::vector<gpu_types::TurnConstants> all;
  for (std::uint32_t i = 0; i < turns; ++i) {
    const glm::dvec2 shift((i + 0.5) / turns - 0.5, radical_inverse(i) + 0.5 / turns - 0.5);  // quarters of a pixel
    const glm::dvec2 pixels = shift / 2.0;
    all.push_back({glm::vec4(pixels, 2.0 * pixels / glm::dvec2(width, height)), {i, turns, 0, 0}});
  }
  return all;
}

glm::vec2 sample_place(const gpu_types::TurnConstants& turn, std::uint32_t s) {
  return glm::vec2(0.25f) + 0.5f * glm::vec2(s & 1, s >> 1) - glm::vec2(turn.shift);
}

}  // namespace subpixel::replay
