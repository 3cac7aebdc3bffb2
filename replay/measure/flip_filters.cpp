#include "replay/measure/flip_filters.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace subpixel::replay {
namespace {

constexpr double pi = std::numbers::pi;

// A Gaussian of the contrast sensitivity functions, a sqrt(pi/b) exp(-pi^2 x^2 / b), x in degrees (section 4.1).
struct SensitivityGaussian {
  double a, b;
};
constexpr SensitivityGaussian achromatic{1, 0.0047};
constexpr SensitivityGaussian red_green{1, 0.0053};
constexpr SensitivityGaussian blue_yellow_wide{34.1, 0.04};
constexpr SensitivityGaussian blue_yellow_narrow{13.5, 0.025};

// Width of the feature detectors in degrees, twice their standard deviation (section 4.2).
constexpr double feature_width_degrees = 0.082;

std::vector<double> gaussian(double radius_scale, int radius) {
  std::vector<double> weights;
  for (int x = 0; x <= radius; ++x) weights.push_back(std::exp(-radius_scale * x * x));
  return weights;
}

// Sum over both sides of a symmetric kernel given by one.
double two_sided_sum(const std::vector<double>& half) {
  double sum = half[0];
  for (std::size_t i = 1; i < half.size(); ++i) sum += 2 * half[i];
  return sum;
}

HalfKernel scaled(const std::vector<double>& half, double scale) {
  HalfKernel kernel;
  for (const double weight : half) kernel.push_back(static_cast<float>(weight * scale));
  return kernel;
}

HalfKernel sensitivity_kernel(const std::vector<double>& half) {
  HalfKernel kernel = scaled(half, 1 / two_sided_sum(half));
  while (kernel.size() > 1 && kernel.back() < 1e-8F * kernel.front()) kernel.pop_back();
  return kernel;
}

// Positive weights scaled to a sum of 1 and negative ones to -1, over both sides.
HalfKernel balanced(std::vector<double> half, bool antisymmetric) {
  double positive = 0;
  double negative = 0;
  for (std::size_t i = 0; i < half.size(); ++i) {
    const double sides = i == 0 || antisymmetric ? 1 : 2;
    // The other side of an antisymmetric kernel is this one's negative: both sums are this side's.
    if (half[i] > 0 || antisymmetric) positive += sides * std::abs(half[i]);
    if (half[i] < 0 || antisymmetric) negative += sides * std::abs(half[i]);
  }
  for (double& weight : half) weight /= weight > 0 ? positive : negative;
  return scaled(half, 1);
}

}  // namespace

FlipKernels flip_kernels(double pixels_per_degree) {
  FlipKernels kernels;
  const int colour_radius =
      static_cast<int>(std::ceil(3 * std::sqrt(blue_yellow_wide.b / (2 * pi * pi)) * pixels_per_degree));
  const auto half = [&](const SensitivityGaussian& g) {
    return gaussian(pi * pi / (g.b * pixels_per_degree * pixels_per_degree), colour_radius);
  };
  kernels.achromatic = sensitivity_kernel(half(achromatic));
  kernels.red_green = sensitivity_kernel(half(red_green));
  // The two-dimensional blue-yellow filter is normalised as a whole, so each part weighs as its own sum over the
  // square.
  const auto weight = [&](const SensitivityGaussian& g) {
    const double sum = two_sided_sum(half(g));
    return g.a * std::sqrt(pi / g.b) * sum * sum;
  };
  kernels.blue_yellow_wide = sensitivity_kernel(half(blue_yellow_wide));
  kernels.blue_yellow_narrow = sensitivity_kernel(half(blue_yellow_narrow));
  kernels.wide_share =
      static_cast<float>(weight(blue_yellow_wide) / (weight(blue_yellow_wide) + weight(blue_yellow_narrow)));

  const double deviation = 0.5 * feature_width_degrees * pixels_per_degree;
  const int feature_radius = static_cast<int>(std::ceil(3 * deviation));
  const std::vector<double> bell = gaussian(1 / (2 * deviation * deviation), feature_radius);
  kernels.smooth = scaled(bell, 1 / two_sided_sum(bell));
  std::vector<double> first;
  std::vector<double> second;
  for (int x = 0; x <= feature_radius; ++x) {
    first.push_back(-x * bell[x]);
    second.push_back((x * x / (deviation * deviation) - 1) * bell[x]);
  }
  kernels.edge = balanced(first, true);
  kernels.point = balanced(second, false);
  kernels.radius = std::max(colour_radius, feature_radius);
  return kernels;
}

PaddedRow::PaddedRow(std::uint32_t width, int margin) : width_(width), margin_(margin) {
  // The filters read whole lanes, up to one group past the margin.
  offset_ = (margin + lane_count - 1) / lane_count * lane_count;
  const std::size_t groups = (width + lane_count - 1) / lane_count;
  values_.assign(offset_ + groups * lane_count + margin + lane_count, 0.0F);
}

void PaddedRow::extend_border() {
  float* row = data();
  std::fill(row - margin_, row, row[0]);
  std::fill(row + width_, row + width_ + margin_, row[width_ - 1]);
}

}  // namespace subpixel::replay
