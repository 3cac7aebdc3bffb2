#include "replay/measure/flip_exposures.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "replay/measure/percentiles.hpp"

namespace subpixel::replay {
namespace {

constexpr double kShoulder = 0.85;  // of the display's range, where both ends of the exposures' range are taken

// The value that the curve takes to kShoulder: the positive root of (a - t c) x^2 + (b - t d) x - t e.
double before_shoulder() {
  const ToneCurve t;
  const double a = t.a - kShoulder * t.c, b = t.b - kShoulder * t.d, c = -kShoulder * t.e;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

float usable(float value) {
  return value > 0 ? value : 0.0f;
}

}  // namespace

ExposureRange exposure_range(const Image& reference) {
  std::vector<double> luminances;
  luminances.reserve(reference.pixels.size() / reference.channels);
  const bool grey = reference.colour_channels() == 1;
  for (std::size_t i = 0; i < reference.pixels.size(); i += reference.channels) {
    if (!is_finite(reference, i / reference.channels)) continue;
    const auto at = [&](std::size_t c) { return static_cast<double>(usable(reference.pixels[i + (grey ? 0 : c)])); };
    luminances.push_back(0.2126 * at(0) + 0.7152 * at(1) + 0.0722 * at(2));
  }
  const double largest = luminances.empty() ? 0 : *std::ranges::max_element(luminances);
  if (largest == 0) return {};
  double middle = median(luminances);
  if (middle == 0) {
    std::erase(luminances, 0.0);
    middle = median(std::move(luminances));
  }
  ExposureRange range;
  range.start = std::log2(before_shoulder() / largest);
  range.stop = std::log2(before_shoulder() / middle);
  range.count = static_cast<std::uint32_t>(std::max(2.0, std::ceil(range.stop - range.start)));
  return range;
}

}  // namespace subpixel::replay
