#include "replay/reference/turns.hpp"

#include <cmath>

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
    const glm::dvec2 shift(0.25 * (i + 0.5) / turns, radical_inverse(i) + 0.5 / turns);
    gpu_types::TurnConstants turn{};
    for (std::uint32_t s = 0; s < 4; ++s) {
      const glm::dvec2 moved = kStandardSamples[s] - shift;
      const glm::dvec2 offset = moved - glm::floor(moved);
      auto& offsets = s < 2 ? turn.offset01 : turn.offset23;
      offsets[static_cast<int>(2 * (s & 1))] = static_cast<float>(offset.x);
      offsets[static_cast<int>(2 * (s & 1) + 1)] = static_cast<float>(offset.y);
      if (moved.x < 0) turn.texel.x |= 1u << (2 * s);
      if (moved.y < 0) turn.texel.x |= 1u << (2 * s + 1);
    }
    // Clip positions of the image to those of the target, where every point is `shift` pixels further right and down.
    const glm::dvec2 size(width, height), target = size + 1.0, scale = size / target;
    turn.clip = glm::vec4(scale, scale - 1.0 + 2.0 * shift / target);
    turn.number = {i, turns, 0, 0};
    all.push_back(turn);
  }
  return all;
}

glm::vec2 sample_position(const gpu_types::TurnConstants& turn, std::uint32_t s) {
  const auto& offsets = s < 2 ? turn.offset01 : turn.offset23;
  const int at = static_cast<int>(2 * (s & 1));
  return {offsets[at], offsets[at + 1]};
}

}  // namespace subpixel::replay
