#include "replay/reference/turns.hpp"

#include <algorithm>
#include <bit>
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

std::uint32_t parity(std::uint32_t bits) {
  return static_cast<std::uint32_t>(std::popcount(bits)) & 1;
}

}  // namespace

std::uint32_t turn_side(std::uint32_t samples, std::uint32_t width, std::uint32_t height) {
  const bool fits = std::max(width, height) <= 4096 && std::uint64_t{width} * height <= 4'000'000;
  return samples >= 256 && samples % 16 == 0 && fits ? 4 : 2;
}

std::vector<gpu_types::TurnConstants> turn_constants(std::uint32_t turns, std::uint32_t side, std::uint32_t width,
                                                     std::uint32_t height) {
  std::vector<gpu_types::TurnConstants> all;
  const int bits = std::bit_width(turns - 1);
  for (std::uint32_t i = 0; i < turns; ++i) {
    const glm::dvec2 shift((i + 0.5) / turns - 0.5, radical_inverse(i) + 0.5 / turns - 0.5);  // cells
    const glm::dvec2 pixels = shift / static_cast<double>(side);
    // Of four samples the right ones have bit 0 and the lower ones bit 1. The even bits of the turn's number choose
    // between left and right, the odd ones between above and below; of an odd number of bits the highest both.
    const std::uint32_t highest = bits % 2 == 1 ? i >> (bits - 1) & 1 : 0, round = i / 4;
    const std::uint32_t sample = parity(i & 0x55555555) | (parity(i & 0xaaaaaaaa) ^ highest) << 1;
    // Within the sample's share of [0, 1) another place for each run of turns that goes through all four.
    const double within = std::fmod(0.5 + round * 0.6180339887498949, 1.0);
    const double choice = std::min((sample + within) / 4, 1.0 - 1e-6);
    all.push_back(
        {glm::vec4(pixels, 2.0 * pixels / glm::dvec2(width, height)), {i, turns, side, 0}, {choice, 0, 0, 0}});
  }
  return all;
}

glm::vec2 sample_place(const gpu_types::TurnConstants& turn, std::uint32_t s) {
  const glm::uvec2 cell((s & 1) | (s >> 1 & 2), (s >> 1 & 1) | (s >> 2 & 2));
  return (glm::vec2(cell) + 0.5f) / static_cast<float>(turn.number.z) - glm::vec2(turn.shift);
}

std::uint32_t shaded_sample(const gpu_types::TurnConstants& turn) {
  return static_cast<std::uint32_t>(turn.choice.x * 4);
}

}  // namespace subpixel::replay
