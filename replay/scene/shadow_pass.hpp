// Draws the sun's depth map by the device's own rasteriser.
#pragma once

#include "replay/scene/gpu_scene.hpp"
#include "replay/scene/shadow_fit.hpp"

namespace subpixel::replay {

// Fills scene.shadow_map with the current frame's draws, both sides of every surface; alpha-tested ones are cut.
// `commands` holds one indirect command for each draw of the frame, in any order.
void render_shadow_map(gpu::Device& device, GpuScene& scene, gpu::Buffer& commands, const ShadowFit& fit);

// The indirect commands of `draws`, in their order.
void write_indirect_commands(const std::vector<DrawItem>& draws, gpu::Buffer& commands);

}  // namespace subpixel::replay
