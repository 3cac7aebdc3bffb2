// FLIP, the difference a person sees when two images alternate in place.
// Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating
// Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020 (High Performance Graphics).
#pragma once

#include <numbers>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

// Section 4.1: a display's pixels per degree of visual angle, distance in metres over the width of `pixels` pixels.
constexpr double pixels_per_degree(double distance_m, double pixels, double width_m) {
  return distance_m * (pixels / width_m) * (std::numbers::pi / 180);
}

struct FlipOptions {
  // The paper's default: a 0.7 m wide display of 3840 pixels seen from 0.7 m, 67.02 pixels per degree.
  double pixels_per_degree = replay::pixels_per_degree(0.7, 3840, 0.7);
  unsigned threads = 2;  // the result is the same for every number
};

struct FlipResult {
  Image map;  // one channel, 0 (no visible difference) to 1
  double mean = 0;
  double minimum = 0, maximum = 0;
  double p99 = 0;  // smallest value that 99% of the pixels don't exceed
  // Weighted percentiles (section 6.2): the value at which the errors below it, added up, reach 25, 50 and 75% of all.
  double weighted_first_quartile = 0, weighted_median = 0, weighted_third_quartile = 0;
};

// Both images are display images of the same size, with 1, 3 or 4 channels; values are clamped to 0..1. A pixel
// that is NaN or infinite in one of them has the largest error, 1; its neighbours' filters take it for black. FLIP is
// symmetric. Throws InputError when the sizes differ or the pixels per degree are not in 1 to 1000.
FlipResult flip(const Image& reference, const Image& test, const FlipOptions& options = {});

// FLIP of linear images: the largest FLIP that a pixel has at any exposure a viewer might choose.
// Andersson, Nilsson, Shirley, Akenine-Moller: "Visualizing Errors in Rendered High Dynamic Range Images",
// Eurographics 2021, short papers. The tone curve is the ACES fit that the paper assumes by default.
struct HdrFlipResult {
  FlipResult error;               // of the maximum over all exposures
  double start = 0, stop = 0;     // log2 of the first and the last exposure's factor
  std::uint32_t exposures = 0;    // evenly spaced from start to stop
  std::vector<std::uint16_t> at;  // for each pixel, the first exposure, from 0, that has its error
};

// Both images are linear. Negative values count as 0, pixels that are not finite as in flip(). The range of exposures
// comes from the reference alone, from its finite pixels: the first brings its largest luminance to 0.85 of the
// display's range, the last its median. So HDR-FLIP is symmetric only between images of the same luminances. Where the
// paper's formulae have no value (a median of 0) the median is that of the luminances above 0; a black reference is
// compared as it is. Throws InputError as flip() does.
HdrFlipResult hdr_flip(const Image& reference, const Image& test, const FlipOptions& options = {});

}  // namespace subpixel::replay
