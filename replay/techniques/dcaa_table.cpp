#include "replay/techniques/dcaa_table.hpp"

#include <algorithm>
#include <cmath>

#include "shaders/frontend/sample_patterns.h"

namespace subpixel::replay {

std::vector<std::uint64_t> coverage_table(const CoverageTableSize& size, std::uint32_t samples) {
  const std::uint64_t all = samples == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << samples) - 1;
  std::vector<std::uint64_t> table(size.entries());
  for (std::uint32_t direction = 0; direction < size.directions; ++direction) {
    const double turn = 4.0 * direction / size.directions;
    const double b = turn <= 2 ? turn - 1 : 3 - turn, a = turn <= 2 ? 1 - std::abs(b) : std::abs(b) - 1;
    const bool first_half = direction < size.directions / 2;
    std::uint64_t* const row = table.data() + std::size_t{direction} * (size.distances + 2);
    row[size.distances + 1] = all;
    for (std::uint32_t distance = 0; distance < size.distances; ++distance) {
      const double centre = (distance + 0.5) * 128 / size.distances - 64;
      std::uint64_t mask = 0;
      for (std::uint32_t i = 0; i < samples; ++i) {
        const auto [x, y] = gpu_types::sample_offset(samples, i);
        const double value = centre + a * x + b * y;
        // On the line itself: with one of the two directions.
        if (value > 0 || (value == 0 && first_half)) mask |= std::uint64_t{1} << i;
      }
      row[distance + 1] = mask;
    }
  }
  return table;
}

std::uint32_t coverage_table_entry(const CoverageTableSize& size, double base, double a, double b) {
  const double length = std::abs(a) + std::abs(b), t = b / length, centre = (base + 0.5) / length;
  const double turn = a >= 0 ? t + 1 : 3 - t;
  const auto direction = static_cast<std::uint32_t>(std::nearbyint(turn * size.directions / 4)) % size.directions;
  const double along = (centre + 64) * size.distances / 128 + 0.5;
  const auto distance = static_cast<std::uint32_t>(std::nearbyint(std::clamp(along, 0.0, size.distances + 1.0)));
  return direction * (size.distances + 2) + distance;
}

}  // namespace subpixel::replay
