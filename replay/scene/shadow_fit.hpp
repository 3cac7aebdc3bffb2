// The sun's orthographic views of what a camera sees: cascades of growing reach.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "replay/scene/camera.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

struct ShadowCascade {
  double scale = 0;  // of the sun's view to [0, 1] across the cascade
  glm::dvec2 offset{0};
  double texel = 0;  // side of a texel in world units
};

struct ShadowFit {
  glm::dmat4 world_to_light{1};  // xy in world units, z depth: 0 at the nearest caster, 1 beyond all
  double depth_per_unit = 0;     // of z along the light
  std::array<ShadowCascade, SUBPIXEL_SHADOW_CASCADES> cascades;

  // World to clip space of one cascade's viewport.
  glm::dmat4 world_to_clip(std::size_t cascade) const;
};

// The last cascade covers all that is visible of `scene`, each before it what is visible within a quarter of the next
// one's distance; in depth each covers the whole scene, since casters may stand outside the view. Sizes are rounded up
// to quarter octaves and origins to whole texels, so that texels stay where they are while the camera moves. `side`:
// texels of a cascade. None when nothing is visible or the light has no direction.
std::optional<ShadowFit> fit_shadow(const Camera& camera, const Bounds& scene, const glm::dvec3& light_direction,
                                    std::uint32_t side);

}  // namespace subpixel::replay
