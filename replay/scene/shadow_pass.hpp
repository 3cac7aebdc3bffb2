// Draws the sun's depth maps by the device's own rasteriser.
#pragma once

#include <vector>

#include "replay/scene/gpu_scene.hpp"
#include "replay/scene/shadow_fit.hpp"

namespace subpixel::replay {

// Fills scene.shadow_map with the current frame's draws, both sides of every surface; alpha-tested ones are cut.
// `instance_bounds`: world bounds of each instance, by its number in scene.instances; each cascade draws those it can
// hold a shadow of.
void render_shadow_map(gpu::Device& device, GpuScene& scene, const std::vector<Bounds>& instance_bounds,
                       const ShadowFit& fit);

}  // namespace subpixel::replay
