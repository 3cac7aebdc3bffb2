#include "replay/scene/shadow_fit.hpp"

#include <algorithm>
#include <cmath>

namespace subpixel::replay {
namespace {

constexpr double kFilterTexels = 4;  // margin on each side
constexpr double kBiasTexels = 1.0;  // taken off the depth of receivers, along the light

}  // namespace

std::optional<ShadowFit> fit_shadow(const Camera& camera, const Bounds& scene, const glm::dvec3& light_direction,
                                    std::uint32_t map_size) {
  const double length = glm::length(light_direction);
  const auto visible = visible_corners(camera, scene);
  if (visible.empty() || !(length > 1e-9) || !std::isfinite(length)) return std::nullopt;
  const glm::dvec3 forward = light_direction / length;
  const glm::dvec3 helper = std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(helper, forward)), up = glm::cross(forward, right);
  const glm::dmat3 to_light = glm::transpose(glm::dmat3(right, up, forward));

  Bounds seen, casters;
  for (const auto& corner : visible) seen.add(to_light * corner);
  for (const auto& corner : scene.corners()) casters.add(to_light * corner);
  if (seen.empty() || casters.empty()) return std::nullopt;

  double side = std::max({seen.size().x, seen.size().y, 1e-6 * glm::length(scene.size()), 1e-9});
  side = std::exp2(std::ceil(4 * std::log2(side)) / 4);
  ShadowFit fit;
  fit.texel = side / (map_size - 2 * kFilterTexels - 1);
  const double width = fit.texel * map_size;
  glm::dvec2 origin = glm::dvec2(seen.centre()) - width / 2;
  origin = glm::floor(origin / fit.texel) * fit.texel;
  const double margin = 1e-3 * casters.size().z + 4 * fit.texel;
  const double depth_begin = casters.low.z - margin, depth = casters.size().z + 2 * margin;

  // Scale and offset after the rotation into the light's axes.
  glm::dmat4 scale(1);
  scale[0][0] = scale[1][1] = 1 / width;
  scale[2][2] = 1 / depth;
  scale[3] = glm::dvec4(-origin.x / width, -origin.y / width, -depth_begin / depth, 1);
  const glm::dmat4 to_map = scale * glm::dmat4(to_light);
  glm::dmat4 map_to_clip(1);
  map_to_clip[0][0] = map_to_clip[1][1] = 2;
  map_to_clip[3] = glm::dvec4(-1, -1, 0, 1);
  fit.world_to_clip = map_to_clip * to_map;
  fit.world_to_map = to_map;
  fit.world_to_map[3][2] -= kBiasTexels * fit.texel / depth;
  return fit;
}

}  // namespace subpixel::replay
