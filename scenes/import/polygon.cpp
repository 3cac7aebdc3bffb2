#include "scenes/import/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numeric>

namespace subpixel::capture {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// The polygon seen against its normal, so that it turns counter-clockwise; about 1 in size.
std::vector<glm::dvec2> flattened(std::span<const glm::dvec3> polygon) {
  glm::dvec3 low = polygon[0], high = polygon[0];
  for (const glm::dvec3& corner : polygon) {
    low = glm::min(low, corner);
    high = glm::max(high, corner);
  }
  const glm::dvec3 size = high / 2.0 - low / 2.0;
  const double extent = std::max({size.x, size.y, size.z});
  const auto at = [&](std::size_t i) { return extent > 0 ? (polygon[i] / 2.0 - low / 2.0) / extent : glm::dvec3(0); };
  glm::dvec3 normal(0);
  for (std::size_t i = 0; i < polygon.size(); ++i) normal += glm::cross(at(i), at((i + 1) % polygon.size()));
  // Dropping the normal's largest axis keeps who is left of whom; the order of the others keeps the turn.
  const glm::dvec3 size_of = glm::abs(normal);
  const int axis = size_of.x >= size_of.y && size_of.x >= size_of.z ? 0 : size_of.y >= size_of.z ? 1 : 2;
  const int u = normal[axis] < 0 ? (axis + 2) % 3 : (axis + 1) % 3;
  const int v = normal[axis] < 0 ? (axis + 1) % 3 : (axis + 2) % 3;
  std::vector<glm::dvec2> flat;
  for (std::size_t i = 0; i < polygon.size(); ++i) flat.emplace_back(at(i)[u], at(i)[v]);
  return flat;
}

// Corners not yet clipped, in a ring.
class Ring {
 public:
  explicit Ring(std::vector<glm::dvec2> corners)
      : corners_(std::move(corners)), next_(corners_.size()), previous_(corners_.size()) {
    const auto count = static_cast<std::uint32_t>(corners_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_[i] = (i + 1) % count;
      previous_[i] = (i + count - 1) % count;
    }
  }

  std::uint32_t next(std::uint32_t i) const { return next_[i]; }
  std::uint32_t previous(std::uint32_t i) const { return previous_[i]; }

  // Twice the signed area of the triangle at the corner; below 0 where the polygon turns inwards.
  double turn(std::uint32_t i) const {
    return cross(corners_[i] - corners_[previous_[i]], corners_[next_[i]] - corners_[i]);
  }

  bool is_ear(std::uint32_t i) const {
    if (turn(i) <= 0) return false;
    const std::uint32_t a = previous_[i], c = next_[i];
    for (std::uint32_t p = next_[c]; p != a; p = next_[p]) {
      if (turn(p) > 0) continue;  // some corner that turns inwards is inside when any is
      if (holds(a, i, c, corners_[p])) return false;
    }
    return true;
  }

  void clip(std::uint32_t i) {
    next_[previous_[i]] = next_[i];
    previous_[next_[i]] = previous_[i];
  }

 private:
  // The edges count, so that no triangle is cut along them; a point equal to a corner does not.
  bool holds(std::uint32_t a, std::uint32_t b, std::uint32_t c, const glm::dvec2& p) const {
    const glm::dvec2 &pa = corners_[a], &pb = corners_[b], &pc = corners_[c];
    if (p == pa || p == pb || p == pc) return false;
    return cross(pb - pa, p - pa) >= 0 && cross(pc - pb, p - pb) >= 0 && cross(pa - pc, p - pc) >= 0;
  }

  std::vector<glm::dvec2> corners_;
  std::vector<std::uint32_t> next_, previous_;
};

void fan(std::uint32_t centre, std::uint32_t count, std::vector<std::uint32_t>& triangles) {
  for (std::uint32_t i = 1; i + 1 < count; ++i) {
    triangles.insert(triangles.end(), {centre, (centre + i) % count, (centre + i + 1) % count});
  }
}

}  // namespace

bool triangulate(std::span<const glm::dvec3> polygon, std::vector<std::uint32_t>& triangles) {
  const auto count = static_cast<std::uint32_t>(polygon.size());
  if (count == 3) {
    fan(0, count, triangles);
    return true;
  }
  constexpr double kFlat = 1e-12;  // turns of less are rounding: the size is 1
  Ring ring(flattened(polygon));
  std::uint32_t inward = 0;
  while (inward < count && ring.turn(inward) >= -kFlat) ++inward;
  if (inward == count || count == 4) {
    fan(inward % count, count, triangles);
    return true;
  }
  if (count > kMaxConcaveCorners) return false;
  std::uint32_t at = 0;
  for (std::uint32_t left = count; left > 3; --left) {
    // Where rounding or a crossing leaves no ear, any corner is taken: the loop ends in any case.
    for (std::uint32_t tries = 0; tries < left && !ring.is_ear(at); ++tries) at = ring.next(at);
    triangles.insert(triangles.end(), {ring.previous(at), at, ring.next(at)});
    ring.clip(at);
    at = ring.next(at);
  }
  triangles.insert(triangles.end(), {ring.previous(at), at, ring.next(at)});
  return true;
}

}  // namespace subpixel::capture
