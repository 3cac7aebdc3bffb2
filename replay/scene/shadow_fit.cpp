#include "replay/scene/shadow_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace subpixel::replay {
namespace {

// Margin on each side of what is covered: what lights.glsl keeps clear, its filter and rounding to texels.
constexpr double kMarginTexels = 12;
constexpr double kReachRatio = 4;  // of the distances two neighbouring cascades cover

ShadowCascade fit_cascade(const Bounds& seen, double smallest_side, std::uint32_t texels) {
  double side = std::max({seen.size().x, seen.size().y, smallest_side});
  side = std::exp2(std::ceil(4 * std::log2(side)) / 4);
  ShadowCascade cascade;
  cascade.texel = side / (texels - 2 * kMarginTexels);
  const double width = cascade.texel * texels;
  const glm::dvec2 origin = glm::floor((glm::dvec2(seen.centre()) - width / 2) / cascade.texel) * cascade.texel;
  cascade.scale = 1 / width;
  cascade.offset = -origin / width;
  return cascade;
}

}  // namespace

glm::dmat4 ShadowFit::world_to_clip(std::size_t cascade) const {
  const auto& c = cascades[cascade];
  glm::dmat4 to_clip(1);
  to_clip[0][0] = to_clip[1][1] = 2 * c.scale;
  to_clip[3] = glm::dvec4(2.0 * c.offset - 1.0, 0, 1);
  return to_clip * world_to_light;
}

std::optional<ShadowFit> fit_shadow(const Camera& camera, const Bounds& scene, const glm::dvec3& light_direction,
                                    std::uint32_t side) {
  const double length = glm::length(light_direction);
  const auto visible = visible_corners(camera, scene);
  if (visible.empty() || !(length > 1e-9) || !std::isfinite(length)) return std::nullopt;
  const glm::dvec3 forward = light_direction / length;
  const glm::dvec3 helper = std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(helper, forward)), up = glm::cross(forward, right);
  const glm::dmat3 to_light = glm::transpose(glm::dmat3(right, up, forward));

  const glm::dvec4 w_row = glm::transpose(camera.view_projection)[3];
  double farthest = 0;
  for (const auto& corner : visible) farthest = std::max(farthest, glm::dot(w_row, glm::dvec4(corner, 1)));
  // The plane of one distance has a direction only under a perspective; an orthographic view has one cascade's worth.
  const double slope = glm::length(glm::dvec3(w_row));

  Bounds casters;
  for (const auto& corner : scene.corners()) casters.add(to_light * corner);
  ShadowFit fit;
  const double smallest = std::max(1e-6 * glm::length(scene.size()), 1e-9);
  for (std::size_t c = 0; c < fit.cascades.size(); ++c) {
    const double reach = farthest / std::pow(kReachRatio, static_cast<double>(fit.cascades.size() - 1 - c));
    std::optional<HalfSpace> near_part;
    if (slope > 1e-9 && c + 1 < fit.cascades.size())
      near_part = HalfSpace{-glm::dvec3(w_row) / slope, (reach - w_row.w) / slope};
    Bounds seen;
    for (const auto& corner : visible_corners(camera, scene, near_part)) seen.add(to_light * corner);
    fit.cascades[c] = seen.empty() ? ShadowCascade{0, {-1, -1}, 0} : fit_cascade(seen, smallest, side);
  }
  const double margin = 1e-3 * casters.size().z + 4 * fit.cascades.back().texel;
  fit.depth_per_unit = 1 / (casters.size().z + 2 * margin);
  glm::dmat4 scale(1);
  scale[2][2] = fit.depth_per_unit;
  scale[3][2] = -(casters.low.z - margin) * fit.depth_per_unit;
  fit.world_to_light = scale * glm::dmat4(to_light);
  return fit;
}

}  // namespace subpixel::replay
