#include "replay/measure/metrics.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

// Mean of `term(offset_a, offset_b)` over pixels and colour channels; the offsets index the two images' values.
template <class Term>
double mean_over_colour(const Image& a, const Image& b, Term term) {
  const std::uint32_t colour = a.colour_channels();
  double sum = 0;
  for (std::uint32_t y = 0; y < a.height; ++y) {
    double row = 0;
    std::size_t at_a = a.offset(0, y);
    std::size_t at_b = b.offset(0, y);
    for (std::uint32_t x = 0; x < a.width; ++x, at_a += a.channels, at_b += b.channels) {
      for (std::uint32_t c = 0; c < colour; ++c) row += term(at_a + c, at_b + c);
    }
    sum += row;
  }
  return sum / (static_cast<double>(a.width) * a.height * colour);
}

constexpr int ssim_radius = 5;
constexpr int ssim_taps = 2 * ssim_radius + 1;

std::array<double, ssim_taps> ssim_window() {
  std::array<double, ssim_taps> window{};
  double sum = 0;
  for (int i = 0; i < ssim_taps; ++i) {
    const double x = i - ssim_radius;
    window[i] = std::exp(-x * x / (2 * 1.5 * 1.5));
    sum += window[i];
  }
  for (double& weight : window) weight /= sum;
  return window;
}

double luma(const Image& image, std::size_t at) {
  if (image.colour_channels() == 1) return image.pixels[at];
  return 0.2126 * image.pixels[at] + 0.7152 * image.pixels[at + 1] + 0.0722 * image.pixels[at + 2];
}

// Window sums of one row: mean of a, b, a*a, b*b and a*b for every window that starts at x.
using Moments = std::array<double, 5>;

std::vector<Moments> horizontal_moments(const Image& a, const Image& b, std::uint32_t y,
                                        const std::array<double, ssim_taps>& window) {
  std::vector<Moments> moments(a.width - ssim_taps + 1);
  for (std::size_t x = 0; x < moments.size(); ++x) {
    Moments sum{};
    for (int i = 0; i < ssim_taps; ++i) {
      const auto column = static_cast<std::uint32_t>(x) + i;
      const double va = luma(a, a.offset(column, y));
      const double vb = luma(b, b.offset(column, y));
      sum[0] += window[i] * va;
      sum[1] += window[i] * vb;
      sum[2] += window[i] * (va * va);
      sum[3] += window[i] * (vb * vb);
      sum[4] += window[i] * (va * vb);
    }
    moments[x] = sum;
  }
  return moments;
}

double ssim_of(const Moments& m) {
  constexpr double c1 = 0.01 * 0.01;
  constexpr double c2 = 0.03 * 0.03;
  const double variance_a = m[2] - m[0] * m[0];
  const double variance_b = m[3] - m[1] * m[1];
  const double covariance = m[4] - m[0] * m[1];
  const double similarity = (2 * m[0] * m[1] + c1) * (2 * covariance + c2) /
                            ((m[0] * m[0] + m[1] * m[1] + c1) * (variance_a + variance_b + c2));
  return std::isfinite(similarity) ? similarity : -1;
}

}  // namespace

void require_same_shape(const Image& a, const Image& b) {
  if (a.width == b.width && a.height == b.height && a.colour_channels() == b.colour_channels() && a.width > 0 &&
      a.height > 0) {
    return;
  }
  const auto shape = [](const Image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height) + " with " +
           std::to_string(image.colour_channels()) + (image.colour_channels() == 1 ? " channel" : " channels");
  };
  throw InputError("images", "cannot compare " + shape(a) + " to " + shape(b), "size");
}

double mse(const Image& reference, const Image& test) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::display && test.encoding == Encoding::display);
  return mean_over_colour(reference, test, [&](std::size_t r, std::size_t t) {
    const double difference = static_cast<double>(test.pixels[t]) - static_cast<double>(reference.pixels[r]);
    return std::isfinite(difference) ? difference * difference : 1.0;
  });
}

double psnr_db(double mse) {
  return -10 * std::log10(mse);
}

double hdr_relative_mse(const Image& reference, const Image& test) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::linear && test.encoding == Encoding::linear);
  return mean_over_colour(reference, test, [&](std::size_t r, std::size_t t) {
    const double expected = reference.pixels[r];
    const double difference = static_cast<double>(test.pixels[t]) - expected;
    return std::isfinite(difference) ? difference * difference / (expected * expected + 0.01) : relative_error_limit;
  });
}

double ssim(const Image& reference, const Image& test) {
  require_same_shape(reference, test);
  assert(reference.encoding == Encoding::display && test.encoding == Encoding::display);
  if (reference.width < ssim_taps || reference.height < ssim_taps) return std::numeric_limits<double>::quiet_NaN();
  const std::array<double, ssim_taps> window = ssim_window();
  std::vector<std::vector<Moments>> rows(ssim_taps);
  double sum = 0;
  for (std::uint32_t y = 0; y < reference.height; ++y) {
    rows[y % ssim_taps] = horizontal_moments(reference, test, y, window);
    if (y + 1 < ssim_taps) continue;
    double row_sum = 0;
    for (std::size_t x = 0; x < rows[0].size(); ++x) {
      Moments moments{};
      for (int i = 0; i < ssim_taps; ++i) {
        const Moments& source = rows[(y + 1 + i) % ssim_taps][x];
        for (std::size_t k = 0; k < moments.size(); ++k) moments[k] += window[i] * source[k];
      }
      row_sum += ssim_of(moments);
    }
    sum += row_sum;
  }
  const double windows = static_cast<double>(rows[0].size()) * (reference.height - ssim_taps + 1);
  return sum / windows;
}

double flicker(const Image& reference_before, const Image& reference_after, const Image& test_before,
               const Image& test_after) {
  require_same_shape(reference_before, reference_after);
  require_same_shape(reference_before, test_before);
  require_same_shape(reference_before, test_after);
  const std::uint32_t colour = reference_before.colour_channels();
  double sum = 0;
  for (std::uint32_t y = 0; y < reference_before.height; ++y) {
    double row = 0;
    for (std::uint32_t x = 0; x < reference_before.width; ++x) {
      const float* r0 = &reference_before.pixels[reference_before.offset(x, y)];
      const float* r1 = &reference_after.pixels[reference_after.offset(x, y)];
      const float* t0 = &test_before.pixels[test_before.offset(x, y)];
      const float* t1 = &test_after.pixels[test_after.offset(x, y)];
      for (std::uint32_t c = 0; c < colour; ++c) {
        const double change = std::abs((static_cast<double>(t1[c]) - t0[c]) - (static_cast<double>(r1[c]) - r0[c]));
        row += std::isfinite(change) ? change : 2.0;
      }
    }
    sum += row;
  }
  return sum / (static_cast<double>(reference_before.width) * reference_before.height * colour);
}

Image error_map(const Image& reference, const Image& test) {
  require_same_shape(reference, test);
  Image map(reference.width, reference.height, 1);
  const std::uint32_t colour = reference.colour_channels();
  for (std::uint32_t y = 0; y < reference.height; ++y) {
    for (std::uint32_t x = 0; x < reference.width; ++x) {
      const float* r = &reference.pixels[reference.offset(x, y)];
      const float* t = &test.pixels[test.offset(x, y)];
      float largest = 0;
      for (std::uint32_t c = 0; c < colour; ++c) {
        const float difference = std::abs(t[c] - r[c]);
        largest = std::max(largest, std::isfinite(difference) ? difference : 1.0F);
      }
      map.pixels[map.offset(x, y)] = largest;
    }
  }
  return map;
}

std::uint64_t group_executions(std::span<const std::uint32_t> counts, std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t kWide = 8, kHigh = 4;
  std::uint64_t sum = 0;
  for (std::uint32_t top = 0; top < height; top += kHigh) {
    for (std::uint32_t left = 0; left < width; left += kWide) {
      const std::uint32_t right = std::min(left + kWide, width), bottom = std::min(top + kHigh, height);
      std::uint32_t most = 0;
      for (std::uint32_t y = top; y < bottom; ++y)
        for (std::uint32_t x = left; x < right; ++x) most = std::max(most, counts[std::size_t{y} * width + x]);
      sum += std::uint64_t{most} * (right - left) * (bottom - top);
    }
  }
  return sum;
}

std::uint64_t invalid_pixels(const Image& image) {
  std::uint64_t invalid = 0;
  for (std::size_t at = 0; at < image.pixels.size(); at += image.channels) {
    bool valid = true;
    for (std::uint32_t c = 0; c < image.channels; ++c) {
      const float value = image.pixels[at + c];
      valid = valid && std::isfinite(value) && value >= 0;
    }
    invalid += valid ? 0 : 1;
  }
  return invalid;
}

std::uint64_t not_finite_pixels(const Image& image) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i) count += is_finite(image, i) ? 0 : 1;
  return count;
}

}  // namespace subpixel::replay
