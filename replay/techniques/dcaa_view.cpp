#include "replay/techniques/dcaa_view.hpp"

#include <cmath>

namespace subpixel::replay {

gpu_types::DcaaView dcaa_view(const glm::mat4& view_projection, std::uint32_t width, std::uint32_t height) {
  // Only the part without translation, so that cameras far from the origin lose nothing.
  const glm::dmat4 rows = glm::transpose(glm::dmat4(view_projection));
  const glm::dvec3 x(rows[0]), y(rows[1]), z(rows[2]), w(rows[3]);
  const bool perspective = glm::length(w) > 1e-9 * glm::length(x);
  // Directions d with (x.d, y.d, w.d) the window position and 1; under parallel projections with z.d = -1 for all rays.
  const glm::dmat3 inverse = glm::inverse(glm::transpose(glm::dmat3(x, y, perspective ? w : z)));
  const glm::dvec3 ray_dx = inverse[0] * (2.0 / width), ray_dy = inverse[1] * (2.0 / height);
  glm::dvec3 ray0 = perspective ? inverse[2] : -inverse[2];
  double scale = 1;
  if (perspective) {
    // Depth is z.d + c / distance; the slopes are those of the second part.
    scale = -glm::dot(z, ray0);
    ray0 += ray_dx * (0.5 - 0.5 * width) + ray_dy * (0.5 - 0.5 * height);
  }
  const glm::dvec3 normal_1 = glm::cross(ray_dx, ray_dy);
  const double side = -1.0 / std::copysign(glm::length(normal_1), glm::dot(normal_1, ray0));
  const auto four = [](const glm::dvec3& v, double last) { return glm::vec4(glm::dvec4(v, last)); };
  gpu_types::DcaaView view;
  view.ray_dx = four(ray_dx, -1e-4 * glm::length(inverse[2]));
  view.ray_dy = four(ray_dy, perspective ? 0.9 : 1e30);
  view.ray0 = four(ray0, 0);
  view.normal_x = four(glm::cross(ray_dy, ray0) * side, 0);
  view.normal_y = four(glm::cross(ray0, ray_dx) * side, 0);
  view.normal_1 = four(normal_1 * side, 0);
  // The eye has clip coordinates (0, 0, w, 0).
  const double eye_depth = perspective ? 1 / glm::inverse(glm::dmat4(view_projection))[2][3] : 1;
  const double along = std::isfinite(eye_depth) && eye_depth > 0 ? eye_depth : 1;
  view.terms = glm::vec4(perspective ? 1.0f : 0.0f, static_cast<float>(scale), static_cast<float>(along), 0);
  return view;
}

}  // namespace subpixel::replay
