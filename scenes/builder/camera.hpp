// Cameras and placements of the scenes we make ourselves, in double and without libm's trigonometry, whose last bits
// differ between machines: a scene is the same bytes everywhere.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

inline constexpr double kPi = 3.14159265358979323846;

// Radians; within 1e-11 for |x| < 1e4. Only +, -, *, / and floor, so the same bits on every IEEE machine.
double sine(double radians);
double cosine(double radians);

Matrix4 to_matrix4(const glm::dmat4& matrix);

glm::dmat4 translation(const glm::dvec3& by);
glm::dmat4 scaling(const glm::dvec3& by);

// Counter-clockwise about a unit axis, seen against it.
glm::dmat4 rotation(const glm::dvec3& axis, double radians);

// First about x, then z, then y: pitch and roll an upright object, then turn it.
glm::dmat4 euler_rotation_degrees(const glm::dvec3& degrees);

// World to view, right-handed, looking down -z, +y up.
glm::dmat4 look_at(const glm::dvec3& eye, const glm::dvec3& target);

// Reversed depth with the far plane at infinity, Vulkan's clip space: y down, z/w = near / distance, so 1 at the near
// plane and towards 0 far away (ClipDepth::one_to_zero, clip_y_up false).
glm::dmat4 perspective(double vertical_fov_degrees, double aspect, double near);

struct CameraKey {
  double time_s = 0;
  glm::dvec3 eye{0, 0, 0};
  glm::dvec3 target{0, 0, -1};
  double vertical_fov_degrees = 50;
};

// A path through keys (times strictly ascending, at least one) by Catmull-Rom splines; still before the first and
// after the last.
class CameraPath {
 public:
  explicit CameraPath(std::vector<CameraKey> keys, double near = 0.1);

  CameraKey at(double time_s) const;

  // Sets view, projection, clip conventions, size and time of `frame`.
  void set(Frame& frame, double time_s, std::uint32_t width, std::uint32_t height) const;

 private:
  std::vector<CameraKey> keys_;
  double near_;
};

}  // namespace subpixel::capture
