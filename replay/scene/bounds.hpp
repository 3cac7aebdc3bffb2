// Axis-aligned boxes that survive broken vertices.
#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace subpixel::replay {

// Coordinates beyond this are taken for damage, like NaN and infinities; squares of it are still finite floats.
inline constexpr double kLargestCoordinate = 1e15;

struct Bounds {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(low.x <= high.x); }
  glm::dvec3 centre() const { return (low + high) * 0.5; }
  glm::dvec3 size() const { return empty() ? glm::dvec3(0) : high - low; }

  // Ignores points that are not finite or beyond kLargestCoordinate.
  void add(const glm::dvec3& point) {
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(point[i]) <= kLargestCoordinate)) return;
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  void add(const Bounds& other) {
    if (other.empty()) return;
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  std::array<glm::dvec3, 8> corners() const {
    std::array<glm::dvec3, 8> all;
    for (int i = 0; i < 8; ++i)
      all[static_cast<std::size_t>(i)] = {i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
    return all;
  }
};

// The box around `bounds` moved by an affine matrix; empty when the matrix is not finite.
inline Bounds transformed(const Bounds& bounds, const glm::dmat4& matrix) {
  Bounds result;
  if (bounds.empty()) return result;
  for (const auto& corner : bounds.corners()) result.add(glm::dvec3(matrix * glm::dvec4(corner, 1)));
  return result;
}

}  // namespace subpixel::replay
