#include "scenes/builder/camera.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <utility>

namespace subpixel::capture {
namespace {

// Taylor polynomials on [-pi/4, pi/4], where the first term left out is below 1e-16.
double polynomial(double x, std::initializer_list<double> highest_first) {
  double sum = 0;
  for (const double coefficient : highest_first) sum = sum * x + coefficient;
  return sum;
}

double sine_near_zero(double x) {
  return x * polynomial(x * x, {-1.0 / 1307674368000, 1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040,
                                1.0 / 120, -1.0 / 6, 1.0});
}

double cosine_near_zero(double x) {
  return polynomial(x * x, {1.0 / 20922789888000, -1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320,
                            -1.0 / 720, 1.0 / 24, -1.0 / 2, 1.0});
}

}  // namespace

double sine(double radians) {
  // Pi/2 in two parts: the first has 33 bits, so quadrant * part is exact.
  constexpr double kHalfPiHigh = 0x1.921fb544p+0;
  constexpr double kHalfPiLow = 0x1.0b4611a626331p-34;
  const double quadrant = std::floor(radians / (kPi / 2) + 0.5);
  const double x = (radians - quadrant * kHalfPiHigh) - quadrant * kHalfPiLow;
  const auto turn = static_cast<long long>(quadrant) & 3;
  const double value = (turn & 1) != 0 ? cosine_near_zero(x) : sine_near_zero(x);
  return turn >= 2 ? -value : value;
}

double cosine(double radians) {
  return sine(radians + kPi / 2);
}

Matrix4 to_matrix4(const glm::dmat4& matrix) {
  Matrix4 out{};
  std::size_t at = 0;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) out[at++] = static_cast<float>(matrix[c][r]);
  }
  return out;
}

glm::dmat4 translation(const glm::dvec3& by) {
  glm::dmat4 matrix(1.0);
  matrix[3] = glm::dvec4(by, 1.0);
  return matrix;
}

glm::dmat4 scaling(const glm::dvec3& by) {
  glm::dmat4 matrix(1.0);
  for (int i = 0; i < 3; ++i) matrix[i][i] = by[i];
  return matrix;
}

glm::dmat4 rotation(const glm::dvec3& axis, double radians) {
  const double s = sine(radians);
  const double c = cosine(radians);
  const glm::dvec3 a = axis * (1.0 - c);
  glm::dmat4 matrix(1.0);
  matrix[0] = {c + a.x * axis.x, a.x * axis.y + s * axis.z, a.x * axis.z - s * axis.y, 0};
  matrix[1] = {a.y * axis.x - s * axis.z, c + a.y * axis.y, a.y * axis.z + s * axis.x, 0};
  matrix[2] = {a.z * axis.x + s * axis.y, a.z * axis.y - s * axis.x, c + a.z * axis.z, 0};
  return matrix;
}

glm::dmat4 euler_rotation_degrees(const glm::dvec3& degrees) {
  const glm::dvec3 radians = degrees * (kPi / 180.0);
  return rotation({0, 1, 0}, radians.y) * rotation({0, 0, 1}, radians.z) * rotation({1, 0, 0}, radians.x);
}

glm::dmat4 look_at(const glm::dvec3& eye, const glm::dvec3& target) {
  const glm::dvec3 back = glm::normalize(eye - target);
  // Looking straight up or down, any horizontal direction may be right.
  const glm::dvec3 up = std::abs(back.y) > 0.9999 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(up, back));
  const glm::dvec3 above = glm::cross(back, right);
  glm::dmat4 view(1.0);
  for (int i = 0; i < 3; ++i) view[i] = glm::dvec4(right[i], above[i], back[i], 0);
  view[3] = glm::dvec4(-glm::dot(right, eye), -glm::dot(above, eye), -glm::dot(back, eye), 1);
  return view;
}

glm::dmat4 perspective(double vertical_fov_degrees, double aspect, double near) {
  const double half = vertical_fov_degrees * (kPi / 360.0);
  const double focal = cosine(half) / sine(half);
  glm::dmat4 projection(0.0);
  projection[0][0] = focal / aspect;
  projection[1][1] = -focal;
  projection[2][3] = -1;
  projection[3][2] = near;
  return projection;
}

CameraPath::CameraPath(std::vector<CameraKey> keys, double near) : keys_(std::move(keys)), near_(near) {
  assert(!keys_.empty());
}

CameraKey CameraPath::at(double time_s) const {
  if (time_s <= keys_.front().time_s) return keys_.front();
  if (time_s >= keys_.back().time_s) return keys_.back();
  const auto next = std::upper_bound(keys_.begin(), keys_.end(), time_s,
                                     [](double time, const CameraKey& key) { return time < key.time_s; });
  const auto i = static_cast<std::size_t>(next - keys_.begin()) - 1;
  const CameraKey& k1 = keys_[i];
  const CameraKey& k2 = keys_[i + 1];
  const CameraKey& k0 = keys_[i == 0 ? 0 : i - 1];
  const CameraKey& k3 = keys_[std::min(i + 2, keys_.size() - 1)];
  const double span = k2.time_s - k1.time_s;
  const double t = (time_s - k1.time_s) / span;
  const double t2 = t * t;
  const double t3 = t2 * t;
  // Hermite with tangents (k2-k0)/(t2-t0) scaled to this span: uneven key times keep the speed continuous.
  const double span1 = k2.time_s - k0.time_s;
  const double span2 = k3.time_s - k1.time_s;
  const auto blend = [&](const auto& p0, const auto& p1, const auto& p2, const auto& p3) {
    const auto m1 = (p2 - p0) * (span / span1);
    const auto m2 = (p3 - p1) * (span / span2);
    return p1 * (2 * t3 - 3 * t2 + 1) + m1 * (t3 - 2 * t2 + t) + p2 * (3 * t2 - 2 * t3) + m2 * (t3 - t2);
  };
  return {time_s, blend(k0.eye, k1.eye, k2.eye, k3.eye), blend(k0.target, k1.target, k2.target, k3.target),
          blend(k0.vertical_fov_degrees, k1.vertical_fov_degrees, k2.vertical_fov_degrees, k3.vertical_fov_degrees)};
}

void CameraPath::set(Frame& frame, double time_s, std::uint32_t width, std::uint32_t height) const {
  const CameraKey key = at(time_s);
  frame.time_s = time_s;
  frame.width = width;
  frame.height = height;
  frame.view = to_matrix4(look_at(key.eye, key.target));
  frame.projection = to_matrix4(perspective(key.vertical_fov_degrees, static_cast<double>(width) / height, near_));
  frame.clip_depth = ClipDepth::one_to_zero;
  frame.clip_y_up = false;
}

}  // namespace subpixel::capture
