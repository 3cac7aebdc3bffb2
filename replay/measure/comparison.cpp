#include "replay/measure/comparison.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "replay/measure/metrics.hpp"

namespace subpixel::replay {
namespace {

void require_same_window(const ImageFile& a, const ImageFile& b) {
  if (a.window == b.window) return;
  const auto words = [](const PixelWindow& window, bool with_place) {
    const std::string size = std::to_string(window.width) + "x" + std::to_string(window.height);
    return with_place ? size + " at " + std::to_string(window.x) + "," + std::to_string(window.y) : size;
  };
  const bool same_size = a.window.width == b.window.width && a.window.height == b.window.height;
  throw InputError("images", "cannot compare " + words(a.window, same_size) + " to " + words(b.window, same_size),
                   a.path.string() + " and " + b.path.string());
}

Image in_colour(const Image& image) {
  if (image.colour_channels() == 3) return image;
  Image colour(image.width, image.height, 3, image.encoding);
  for (std::size_t i = 0; i < colour.pixels.size(); ++i) colour.pixels[i] = image.pixels[i / 3 * image.channels];
  return colour;
}

void find_differences(const Image& a, const Image& b, Comparison& result) {
  for (std::uint32_t y = 0; y < a.height; ++y) {
    for (std::uint32_t x = 0; x < a.width; ++x) {
      double largest = 0;
      for (std::uint32_t c = 0; c < a.colour_channels(); ++c) {
        const double difference =
            std::abs(static_cast<double>(a.pixels[a.offset(x, y) + c]) - b.pixels[b.offset(x, y) + c]);
        largest = std::max(largest, std::isfinite(difference) ? difference : std::numeric_limits<double>::infinity());
      }
      result.differing_pixels += largest > 0 ? 1 : 0;
      if (largest <= result.largest_difference) continue;
      result.largest_difference = largest;
      result.largest_at = {x, y};
    }
  }
}

std::uint64_t count_clamped(const Image& image) {
  if (image.encoding == Encoding::display) return 0;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += image.channels) {
    bool outside = false;
    for (std::uint32_t c = 0; c < image.colour_channels(); ++c) {
      const float value = image.pixels[i + c];
      outside = outside || (std::isfinite(value) && (value < 0 || value > 1));
    }
    count += outside ? 1 : 0;
  }
  return count;
}

void compare_alpha(const Image& a, const Image& b, Comparison& result) {
  if (a.channels != 4 && b.channels != 4) return;
  const auto alpha = [](const Image& image, std::size_t i) {
    return image.channels == 4 ? static_cast<double>(image.pixels[4 * i + 3]) : 1.0;
  };
  const std::size_t pixels = std::size_t{a.width} * a.height;
  double sum = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const double difference = alpha(a, i) - alpha(b, i);
    if (difference != 0) ++result.alpha_differing_pixels;  // NaN too
    sum += std::isfinite(difference) ? difference * difference : 1.0;
  }
  result.alpha_mse = sum / static_cast<double>(pixels);
}

}  // namespace

Comparison compare_images(const ImageFile& reference, const ImageFile& test, const FlipOptions& viewing) {
  require_same_window(reference, test);
  const bool both_grey = reference.image.colour_channels() == 1 && test.image.colour_channels() == 1;
  const Image a = both_grey ? reference.image : in_colour(reference.image);
  const Image b = both_grey ? test.image : in_colour(test.image);
  const Image shown_a = to_display(a), shown_b = to_display(b);
  const bool linear = a.encoding == Encoding::linear && b.encoding == Encoding::linear;

  Comparison result{.width = a.width, .height = a.height};
  find_differences(linear ? a : shown_a, linear ? b : shown_b, result);
  result.not_finite_pixels = {not_finite_pixels(a), not_finite_pixels(b)};
  result.clamped_pixels = {count_clamped(a), count_clamped(b)};
  result.mse = mse(shown_a, shown_b);
  result.psnr_db = psnr_db(result.mse);
  result.ssim = ssim(shown_a, shown_b);
  result.flip = flip(shown_a, shown_b, viewing);
  if (linear) {
    result.hdr_relative_mse = hdr_relative_mse(a, b);
    result.hdr_flip = hdr_flip(a, b, viewing);
  }
  compare_alpha(reference.image, test.image, result);
  return result;
}

}  // namespace subpixel::replay
