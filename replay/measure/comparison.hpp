// Two image files beside each other: all that `subpixel compare` says.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "replay/measure/flip.hpp"
#include "replay/measure/image_file.hpp"

namespace subpixel::replay {

struct Comparison {
  std::uint32_t width = 0, height = 0;

  // Pixels with any difference of colour, the largest difference of a channel and its first place. Of the values as
  // they are when both images are linear, else of display values. Infinite where a value is not finite.
  std::uint64_t differing_pixels = 0;
  double largest_difference = 0;
  std::array<std::uint32_t, 2> largest_at{};

  // Of the reference and of the test: pixels with a colour that is NaN or infinite, and linear ones with one outside of
  // 0 to 1, where the metrics of display values see 0 or 1.
  std::array<std::uint64_t, 2> not_finite_pixels{}, clamped_pixels{};

  // On display values.
  double mse = 0, psnr_db = 0, ssim = 0;
  FlipResult flip;

  // When both images are linear.
  std::optional<double> hdr_relative_mse;
  std::optional<HdrFlipResult> hdr_flip;

  // When one of them has alpha; the other's then is 1. Colours are compared as they are stored, whatever alpha is.
  std::optional<double> alpha_mse;
  std::uint64_t alpha_differing_pixels = 0;
};

// Grey is compared with colour as three equal channels. Throws InputError that names both files when their windows
// differ, and as flip() does.
Comparison compare_images(const ImageFile& reference, const ImageFile& test, const FlipOptions& viewing);

}  // namespace subpixel::replay
