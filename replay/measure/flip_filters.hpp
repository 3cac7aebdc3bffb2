// The filters of FLIP as sums of separable ones, and the rows they run on.
#pragma once

#include <cstdint>
#include <vector>

namespace subpixel::replay {

// Eight neighbouring pixels. Elementwise arithmetic only, so every instruction set computes the same bits.
using Lanes = float __attribute__((vector_size(32)));
inline constexpr int lane_count = 8;

// One side of a symmetric or antisymmetric one-dimensional kernel: weight[0] belongs to the centre.
using HalfKernel = std::vector<float>;

struct FlipKernels {
  // Contrast sensitivity (section 4.1, table 1): one Gaussian for the achromatic and the red-green channel, the
  // weighted sum of two for blue-yellow, each separable. Weights below 1e-8 of the centre are cut.
  HalfKernel achromatic, red_green, blue_yellow_wide, blue_yellow_narrow;
  float wide_share = 0;  // of the blue-yellow filter's sum
  // Feature detection (section 4.2): Gaussian, its negated first derivative and its second derivative. The positive
  // weights of a two-dimensional product add up to 1 and the negative ones to -1.
  HalfKernel smooth, edge, point;
  int radius = 0;  // the longest kernel's
};

FlipKernels flip_kernels(double pixels_per_degree);

// A row of pixels with `margin` more on either side and room for whole groups of lanes; zero-filled.
class PaddedRow {
 public:
  PaddedRow(std::uint32_t width, int margin);
  float* data() { return values_.data() + offset_; }
  const float* data() const { return values_.data() + offset_; }
  // Repeats the first and the last pixel into the margins: images go on with their border.
  void extend_border();

 private:
  std::vector<float> values_;
  std::uint32_t width_;
  int margin_, offset_;
};

}  // namespace subpixel::replay
