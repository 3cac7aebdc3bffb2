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

// Which bits of the cell each bit of a turn's number turns over, the lowest bit first. Bit 0 of an entry is the first
// binary digit of the cell's column, then come the other digits of the column, then those of the row. A shift's x
// begins with the turn's high bits and its y with the low ones; with these tables any k digits of a shading point's x
// and m - k of its y are independent functions of the m bits. Found by trying; ReferenceTurns checks them.
constexpr std::uint8_t kSixteen[][8] = {{5, 11},
                                        {1, 6, 10},
                                        {1, 3, 4, 8},
                                        {1, 2, 4, 8, 5},
                                        {15, 5, 11, 9, 10, 12},
                                        {1, 2, 7, 10, 1, 9, 4},
                                        {7, 6, 12, 14, 3, 4, 5, 12}};

// The cell of a turn: column's digits, then row's, as above. `bits`: of all turns' numbers.
std::uint32_t cell_digits(std::uint32_t turn, int bits, std::uint32_t side) {
  std::uint32_t digits = 0;
  for (int j = 0; j < bits; ++j) {
    if ((turn >> j & 1) == 0) continue;
    if (side == 4) {
      digits ^= kSixteen[std::clamp(bits, 2, 8) - 2][std::min(j, 7)];
    } else {
      digits ^= bits % 2 == 1 && j == bits - 1 ? 3 : 1 + j % 2;
    }
  }
  return digits;
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
    // Samples go by Morton's order, whose highest digits are the first of the row and the column.
    const std::uint32_t digits = cell_digits(i, bits, side), cells = side * side;
    std::uint32_t sample = (digits & 1) | (digits >> 1 & 1) << 1;
    if (side == 4) sample = (digits >> 1 & 1) | (digits >> 3 & 1) << 1 | (digits & 1) << 2 | (digits >> 2 & 1) << 3;
    // Within the sample's share of [0, 1) another place for each run of turns that goes through all samples.
    const std::uint32_t round = i / cells;
    const double within = std::fmod(0.5 + round * 0.6180339887498949, 1.0);
    const double choice = std::min((sample + within) / cells, 1.0 - 1e-6);
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
  return static_cast<std::uint32_t>(turn.choice.x * static_cast<float>(turn.number.z * turn.number.z));
}

}  // namespace subpixel::replay
