#include "replay/scene/camera.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

bool finite(const glm::dmat4& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

}  // namespace

glm::dmat4 matrix(const capture::Matrix4& column_major) {
  glm::dmat4 result;
  std::size_t next = 0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) result[c][r] = static_cast<double>(column_major[next++]);
  return result;
}

Camera camera_of(const capture::Frame& frame, std::uint32_t index) {
  glm::dmat4 to_vulkan(1);
  if (frame.clip_y_up) to_vulkan[1][1] = -1;
  switch (frame.clip_depth) {
    case capture::ClipDepth::one_to_zero:
      break;
    case capture::ClipDepth::zero_to_one:  // z' = w - z
      to_vulkan[2][2] = -1;
      to_vulkan[3][2] = 1;
      break;
    case capture::ClipDepth::minus_one_to_one:  // z' = (w - z) / 2
      to_vulkan[2][2] = -0.5;
      to_vulkan[3][2] = 0.5;
      break;
  }
  Camera camera;
  camera.view = matrix(frame.view);
  camera.view_projection = to_vulkan * matrix(frame.projection) * camera.view;
  camera.inverse_view_projection = glm::inverse(camera.view_projection);
  const glm::dmat4 inverse_view = glm::inverse(camera.view);
  camera.eye = glm::dvec3(inverse_view[3]);
  if (!finite(camera.view_projection) || !finite(camera.inverse_view_projection) || !finite(inverse_view))
    throw InputError("camera", "view or projection matrix is not finite or has no inverse",
                     fmt::format("frame {}", index));
  return camera;
}

glm::dmat4 moved_image(const glm::dvec2& pixels, const glm::dvec2& size) {
  glm::dmat4 move(1);
  move[3][0] = 2 * pixels.x / size.x;
  move[3][1] = 2 * pixels.y / size.y;
  return move;
}

std::vector<glm::dvec3> visible_corners(const Camera& camera, const Bounds& bounds,
                                        const std::optional<HalfSpace>& part) {
  std::vector<glm::dvec3> corners;
  if (bounds.empty()) return corners;
  std::vector<HalfSpace> spaces;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0);
    normal[axis] = 1;
    spaces.push_back({normal, -bounds.low[axis]});
    spaces.push_back({-normal, bounds.high[axis]});
  }
  const glm::dmat4 rows = glm::transpose(camera.view_projection);
  const glm::dvec4 planes[] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                               rows[3] - rows[1], rows[3] - rows[2], rows[2]};
  for (const auto& plane : planes) {
    const double length = glm::length(glm::dvec3(plane));
    // The far plane of an infinite projection has no direction; all finite points are before it.
    if (length > 1e-12 * glm::length(plane)) spaces.push_back({glm::dvec3(plane) / length, plane.w / length});
  }
  if (part) spaces.push_back(*part);
  // Few planes: every corner is where three of them meet inside all others.
  const double tolerance = 1e-7 * (glm::length(bounds.size()) + 1e-30);
  for (std::size_t i = 0; i < spaces.size(); ++i)
    for (std::size_t j = i + 1; j < spaces.size(); ++j)
      for (std::size_t k = j + 1; k < spaces.size(); ++k) {
        const auto &a = spaces[i], &b = spaces[j], &c = spaces[k];
        const glm::dvec3 bc = glm::cross(b.normal, c.normal);
        const double determinant = glm::dot(a.normal, bc);
        if (std::abs(determinant) < 1e-9) continue;
        const glm::dvec3 point =
            -(bc * a.offset + glm::cross(c.normal, a.normal) * b.offset + glm::cross(a.normal, b.normal) * c.offset) /
            determinant;
        bool inside = true;
        for (const auto& space : spaces) inside = inside && space.distance(point) >= -tolerance;
        if (inside) corners.push_back(point);
      }
  return corners;
}

}  // namespace subpixel::replay
