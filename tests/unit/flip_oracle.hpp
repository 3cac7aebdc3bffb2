// FLIP written down from the paper's equations, in doubles and with its two-dimensional filters as they stand. Slow and
// separate from the code under test, which it is the oracle for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay::oracle {

using Triple = std::array<double, 3>;
using Plane = std::vector<double>;

struct Kernel {
  int radius = 0;
  Plane weights;  // (2 radius + 1)^2
  double& at(int x, int y) { return weights[(y + radius) * (2 * radius + 1) + x + radius]; }
  double at(int x, int y) const { return weights[(y + radius) * (2 * radius + 1) + x + radius]; }
};

inline Kernel empty_kernel(int radius) {
  return {radius, Plane(static_cast<std::size_t>(2 * radius + 1) * (2 * radius + 1), 0.0)};
}

inline Kernel sensitivity(double ppd, double a1, double b1, double a2, double b2) {
  constexpr double pi = std::numbers::pi;
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
  Kernel kernel = empty_kernel(radius);
  double sum = 0;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const double d2 = (x * x + y * y) / (ppd * ppd);
      const double weight = a1 * std::sqrt(pi / b1) * std::exp(-pi * pi * d2 / b1) +
                            (a2 == 0 ? 0 : a2 * std::sqrt(pi / b2) * std::exp(-pi * pi * d2 / b2));
      kernel.at(x, y) = weight;
      sum += weight;
    }
  }
  for (double& weight : kernel.weights) weight /= sum;
  return kernel;
}

// Horizontal detector; `point` chooses the second derivative.
inline Kernel detector(double ppd, bool point) {
  const double deviation = 0.5 * 0.082 * ppd;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  Kernel kernel = empty_kernel(radius);
  double positive = 0;
  double negative = 0;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const double bell = std::exp(-(x * x + y * y) / (2 * deviation * deviation));
      const double weight = (point ? x * x / (deviation * deviation) - 1 : -x) * bell;
      kernel.at(x, y) = weight;
      (weight > 0 ? positive : negative) += std::abs(weight);
    }
  }
  for (double& weight : kernel.weights) weight /= weight > 0 ? positive : negative;
  return kernel;
}

inline Plane convolve(const Plane& plane, int width, int height, const Kernel& kernel, bool transposed) {
  Plane out(plane.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int j = -kernel.radius; j <= kernel.radius; ++j) {
        for (int i = -kernel.radius; i <= kernel.radius; ++i) {
          const int sx = std::clamp(x + i, 0, width - 1);
          const int sy = std::clamp(y + j, 0, height - 1);
          sum += plane[sy * width + sx] * (transposed ? kernel.at(j, i) : kernel.at(i, j));
        }
      }
      out[y * width + x] = sum;
    }
  }
  return out;
}

// sRGB to XYZ for D65, and the white it gives.
inline constexpr double matrix[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                        {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                        {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

inline Triple xyz_over_white(const Triple& rgb) {
  Triple out{};
  for (int i = 0; i < 3; ++i) {
    const double white = matrix[i][0] + matrix[i][1] + matrix[i][2];
    out[i] = (matrix[i][0] * rgb[0] + matrix[i][1] * rgb[1] + matrix[i][2] * rgb[2]) / white;
  }
  return out;
}

// Solves matrix * rgb = xyz by Cramer's rule.
inline Triple rgb_from(const Triple& over_white) {
  const auto determinant = [](const double(&m)[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  Triple out{};
  for (int column = 0; column < 3; ++column) {
    double replaced[3][3];
    for (int i = 0; i < 3; ++i) {
      const double white = matrix[i][0] + matrix[i][1] + matrix[i][2];
      for (int j = 0; j < 3; ++j) replaced[i][j] = j == column ? over_white[i] * white : matrix[i][j];
    }
    out[column] = determinant(replaced) / determinant(matrix);
  }
  return out;
}

inline Triple hunt_lab(const Triple& rgb) {
  const auto f = [](double t) {
    constexpr double delta = 6.0 / 29.0;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29.0;
  };
  const Triple xyz = xyz_over_white(rgb);
  const double lightness = 116 * f(xyz[1]) - 16;
  return {lightness, 0.01 * lightness * 500 * (f(xyz[0]) - f(xyz[1])),
          0.01 * lightness * 200 * (f(xyz[1]) - f(xyz[2]))};
}

inline double hyab(const Triple& a, const Triple& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

struct Features {
  std::vector<Triple> lab;
  Plane edge, point;
};

inline Features features(const Image& image, double ppd) {
  const int width = static_cast<int>(image.width);
  const int height = static_cast<int>(image.height);
  const std::size_t size = static_cast<std::size_t>(width) * height;
  const auto decode = [&](double v) {
    if (image.encoding == Encoding::linear) return v;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  std::array<Plane, 3> opponent{Plane(size), Plane(size), Plane(size)};
  Plane luminance(size);
  for (std::size_t i = 0; i < size; ++i) {
    const float* pixel = &image.pixels[i * image.channels];
    const Triple xyz = xyz_over_white({decode(pixel[0]), decode(pixel[1]), decode(pixel[2])});
    opponent[0][i] = 116 * xyz[1] - 16;
    opponent[1][i] = 500 * (xyz[0] - xyz[1]);
    opponent[2][i] = 200 * (xyz[1] - xyz[2]);
    luminance[i] = (opponent[0][i] + 16) / 116;
  }
  const std::array<Kernel, 3> sensitivities{sensitivity(ppd, 1, 0.0047, 0, 1e-5), sensitivity(ppd, 1, 0.0053, 0, 1e-5),
                                            sensitivity(ppd, 34.1, 0.04, 13.5, 0.025)};
  for (int c = 0; c < 3; ++c) opponent[c] = convolve(opponent[c], width, height, sensitivities[c], false);
  Features out;
  for (std::size_t i = 0; i < size; ++i) {
    const double y = (opponent[0][i] + 16) / 116;
    Triple rgb = rgb_from({y + opponent[1][i] / 500, y, y - opponent[2][i] / 200});
    for (double& channel : rgb) channel = std::clamp(channel, 0.0, 1.0);
    out.lab.push_back(hunt_lab(rgb));
  }
  const auto length = [&](const Kernel& kernel) {
    Plane x = convolve(luminance, width, height, kernel, false);
    const Plane y = convolve(luminance, width, height, kernel, true);
    for (std::size_t i = 0; i < size; ++i) x[i] = std::hypot(x[i], y[i]);
    return x;
  };
  out.edge = length(detector(ppd, false));
  out.point = length(detector(ppd, true));
  return out;
}

// Errors of all pixels, row by row.
inline Plane flip(const Image& reference, const Image& test, double ppd) {
  const Features r = features(reference, ppd);
  const Features t = features(test, ppd);
  const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7);
  Plane errors(r.lab.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double difference = std::pow(hyab(r.lab[i], t.lab[i]), 0.7);
    const double knee = 0.4 * largest;
    const double colour =
        difference < knee ? 0.95 / knee * difference : 0.95 + (difference - knee) / (largest - knee) * 0.05;
    const double feature =
        std::sqrt(std::max(std::abs(r.edge[i] - t.edge[i]), std::abs(r.point[i] - t.point[i])) / std::numbers::sqrt2);
    errors[i] = std::pow(colour, 1 - feature);
  }
  return errors;
}

}  // namespace subpixel::replay::oracle
