// Colour spaces of FLIP, on groups of pixels. For the same file as flip_lanes.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "replay/measure/flip_lanes.hpp"

namespace subpixel::replay {

// Linear sRGB to CIE XYZ over the white point (IEC 61966-2-1 primaries, D65), so that white is (1, 1, 1), and back.
struct Colour {
  Lanes x, y, z;
};

inline constexpr double xyz_from_rgb[3][3] = {{10135552.0 / 23359437, 8788810.0 / 23359437, 4435075.0 / 23359437},
                                              {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                              {1425312.0 / 80288307, 8788810.0 / 80288307, 70074185.0 / 80288307}};

// Inverse of a 3x3 matrix by cofactors.
constexpr std::array<std::array<float, 3>, 3> inverse(const double (&m)[3][3]) {
  std::array<std::array<float, 3>, 3> out{};
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (j + 1) % 3;
      const int b = (j + 2) % 3;
      const int c = (i + 1) % 3;
      const int d = (i + 2) % 3;
      out[i][j] = static_cast<float>((m[a][c] * m[b][d] - m[a][d] * m[b][c]) / determinant);
    }
  }
  return out;
}

inline constexpr std::array<std::array<float, 3>, 3> rgb_from_xyz = inverse(xyz_from_rgb);

inline Colour to_xyz(const Colour& rgb) {
  const auto row = [&](const double(&m)[3]) {
    return static_cast<float>(m[0]) * rgb.x + static_cast<float>(m[1]) * rgb.y + static_cast<float>(m[2]) * rgb.z;
  };
  return {row(xyz_from_rgb[0]), row(xyz_from_rgb[1]), row(xyz_from_rgb[2])};
}

inline Colour to_rgb(const Colour& xyz) {
  const auto row = [&](const std::array<float, 3>& m) { return m[0] * xyz.x + m[1] * xyz.y + m[2] * xyz.z; };
  return {row(rgb_from_xyz[0]), row(rgb_from_xyz[1]), row(rgb_from_xyz[2])};
}

// CIELAB's companding (CIE 15).
inline Lanes lab_curve(Lanes value) {
  constexpr float delta = 6.0F / 29.0F;
  const Lanes straight = value * (1.0F / (3.0F * delta * delta)) + 4.0F / 29.0F;
  const LaneBits above = value > delta * delta * delta;
  return above ? cube_root(above ? value : all(1)) : straight;
}

// L*, and a* and b* scaled by lightness: the Hunt effect (section 4.1.2).
inline Colour hunt_lab(const Colour& xyz) {
  const Lanes x = lab_curve(xyz.x);
  const Lanes y = lab_curve(xyz.y);
  const Lanes z = lab_curve(xyz.z);
  const Lanes lightness = 116.0F * y - 16.0F;
  const Lanes hunt = 0.01F * lightness;
  return {lightness, hunt * (500.0F * (x - y)), hunt * (200.0F * (y - z))};
}

// sRGB decoding by linear interpolation between 16 points for each step of an 8-bit value: exact at 8-bit values, and
// within 3e-8 between them.
class DecodeTable {
 public:
  DecodeTable() {
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const double display = static_cast<double>(std::min(i, steps)) / steps;
      const double linear = display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
      table_[i] = static_cast<float>(linear);
    }
  }
  float operator()(float display) const {
    if (!(display > 0)) return 0;
    const float at = std::min(display, 1.0F) * static_cast<float>(steps);
    const auto below = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(below);
    return table_[below] + share * (table_[below + 1] - table_[below]);
  }

 private:
  static constexpr std::size_t steps = 255 * 16;
  std::array<float, steps + 2> table_{};
};

}  // namespace subpixel::replay
