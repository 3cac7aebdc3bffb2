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

// Narkowicz's fit of the ACES curve, (a x^2 + b x) / (c x^2 + d x + e), with its pre-exposure of 0.6 taken out, as the
// paper's authors use it.
struct ToneCurve {
  double a = 0.6 * 0.6 * 2.51, b = 0.6 * 0.03, c = 0.6 * 0.6 * 2.43, d = 0.6 * 0.59, e = 0.14;
};

}  // namespace subpixel::replay
