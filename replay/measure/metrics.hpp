// Differences between an image and its reference. Sums are in double, row by row in one order, so a metric has the same
// bits whatever the number of threads. All take images of equal size, or throw InputError that names both sizes.
// A value that is NaN or infinite counts as the largest difference there can be, in whichever image it is, and also
// where both have the same: such a pixel is never equal to anything.
#pragma once

#include <cstdint>
#include <span>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

// Throws InputError unless both images have the same width, height and number of colour channels.
void require_same_shape(const Image& a, const Image& b);

// Mean over pixels and colour channels of (test - reference)^2, on display values; the largest is 1.
double mse(const Image& reference, const Image& test);

// -10 log10(mse) dB, for a peak of 1; infinite when the images are equal.
double psnr_db(double mse);

// On linear values: mean over pixels and colour channels of (test - reference)^2 / (reference^2 + 0.01). The constant
// keeps dark references from ruling the mean, as in Rousselle et al. 2011 (there 0.001) and in the denoising literature
// since, where 0.01 is usual. A value that is not finite counts as the largest float against 0: relative_error_limit.
inline constexpr double relative_error_limit = 3.4028234663852886e38 * 3.4028234663852886e38 / 0.01;
double hdr_relative_mse(const Image& reference, const Image& test);

// Structural similarity, Wang et al. 2004: Rec. 709 luma of the display values, 11x11 Gaussian of sigma 1.5, K1 = 0.01,
// K2 = 0.03, mean over the windows that lie wholly inside. 1 for equal images; NaN when a side is below 11 pixels. A
// window with a pixel that is not finite counts as -1.
double ssim(const Image& reference, const Image& test);

// Over time: mean over pixels and colour channels of |(test[k+1] - test[k]) - (reference[k+1] - reference[k])|, on
// display values; the largest is 2. What moves in the test but not in the reference.
double flicker(const Image& reference_before, const Image& reference_after, const Image& test_before,
               const Image& test_after);

// One channel: the largest difference of a pixel's colour channels, |test - reference|, on display values; 1 where a
// value is not finite.
Image error_map(const Image& reference, const Image& test);

// Lighting executions where groups of 8x4 pixels take as long as their busiest: the sum over groups, smaller at the
// right and lower edge, of their largest count times their pixels. `counts`: of width x height pixels, row by row.
std::uint64_t group_executions(std::span<const std::uint32_t> counts, std::uint32_t width, std::uint32_t height);

// Pixels with a value that is NaN, infinite or negative in any channel: 0 in every image of a working technique.
std::uint64_t invalid_pixels(const Image& image);

// Pixels with a colour that is NaN or infinite.
std::uint64_t not_finite_pixels(const Image& image);

}  // namespace subpixel::replay
