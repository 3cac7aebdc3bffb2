// The exposures of HDR-FLIP (section 3 of its paper; flip.hpp names it).
#pragma once

#include <cstdint>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

struct ExposureRange {
  double start = 0, stop = 0;  // log2 of the factor on linear values
  std::uint32_t count = 1;     // max(2, ceil(stop - start)); 1 for a reference without light
};

ExposureRange exposure_range(const Image& reference);

// 2^exposure times the image through the tone curve, clamped to 0..1; still linear.
Image tone_mapped(const Image& image, double exposure);

}  // namespace subpixel::replay
