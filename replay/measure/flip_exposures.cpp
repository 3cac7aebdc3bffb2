#include "replay/measure/flip_exposures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace subpixel::replay {
namespace {

// Narkowicz's fit of the ACES curve, (a x^2 + b x) / (c x^2 + d x + e), with its pre-exposure of 0.6 taken out, as the
// paper's authors use it.
constexpr double kA = 0.6 * 0.6 * 2.51, kB = 0.6 * 0.03, kC = 0.6 * 0.6 * 2.43, kD = 0.6 * 0.59, kE = 0.14;
constexpr double kShoulder = 0.85;  // of the display's range, where both ends of the exposures' range are taken

// The value that the curve takes to kShoulder: the positive root of (a - t c) x^2 + (b - t d) x - t e.
double before_shoulder() {
  const double a = kA - kShoulder * kC, b = kB - kShoulder * kD, c = -kShoulder * kE;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

float usable(float value) {
  return value > 0 ? std::min(value, std::numeric_limits<float>::max()) : 0.0f;
}

double median(std::vector<double>& sorted) {
  const std::size_t middle = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

}  // namespace

ExposureRange exposure_range(const Image& reference) {
  std::vector<double> luminances;
  luminances.reserve(reference.pixels.size() / reference.channels);
  const bool grey = reference.colour_channels() == 1;
  for (std::size_t i = 0; i < reference.pixels.size(); i += reference.channels) {
    const auto at = [&](std::size_t c) { return static_cast<double>(usable(reference.pixels[i + (grey ? 0 : c)])); };
    luminances.push_back(0.2126 * at(0) + 0.7152 * at(1) + 0.0722 * at(2));
  }
  std::sort(luminances.begin(), luminances.end());
  if (luminances.empty() || luminances.back() == 0) return {};
  const double largest = luminances.back();
  double middle = median(luminances);
  if (middle == 0) {
    luminances.erase(luminances.begin(), std::upper_bound(luminances.begin(), luminances.end(), 0.0));
    middle = median(luminances);
  }
  ExposureRange range;
  range.start = std::log2(before_shoulder() / largest);
  range.stop = std::log2(before_shoulder() / middle);
  range.count = static_cast<std::uint32_t>(std::max(2.0, std::ceil(range.stop - range.start)));
  return range;
}

Image tone_mapped(const Image& image, double exposure) {
  Image mapped = image;
  const auto factor = static_cast<float>(std::exp2(exposure));
  constexpr auto a = static_cast<float>(kA), b = static_cast<float>(kB), c = static_cast<float>(kC),
                 d = static_cast<float>(kD), e = static_cast<float>(kE);
  for (float& value : mapped.pixels) {
    // Beyond 2^40 the curve is flat; its squares stay finite there.
    const float x = std::min(usable(value) * factor, 0x1p40f);
    value = std::min(x * (a * x + b) / (x * (c * x + d) + e), 1.0f);
  }
  return mapped;
}

}  // namespace subpixel::replay
