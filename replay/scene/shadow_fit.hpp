// The sun's orthographic view of what a camera sees.
#pragma once

#include <optional>

#include "replay/scene/camera.hpp"

namespace subpixel::replay {

struct ShadowFit {
  glm::dmat4 world_to_map{1};   // texture coordinates in x and y, depth in z: 0 at the nearest caster, 1 beyond all
  glm::dmat4 world_to_clip{1};  // the same for drawing the map
  double texel = 0;             // side of a texel in world units
};

// Covers the visible part of `scene` with a margin for the filter, and in depth all of it, since casters may stand
// outside the view. Sizes are rounded up to quarter octaves and the origin to whole texels, so that the pattern of
// texels stays where it is while the camera moves. None when nothing is visible or the light has no direction.
std::optional<ShadowFit> fit_shadow(const Camera& camera, const Bounds& scene, const glm::dvec3& light_direction,
                                    std::uint32_t map_size);

}  // namespace subpixel::replay
