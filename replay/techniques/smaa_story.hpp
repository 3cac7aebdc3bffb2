// What the passes of `smaa` make of one pixel, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "shaders/techniques/smaa/story_interface.h"

namespace subpixel::replay {

// Step after step, each with its numbers and a sentence: edges and weights of the pixel, its eastern and its southern
// neighbour, then the blend.
nlohmann::json smaa_filter(std::span<const gpu_types::SmaaEdgesStory> edges,
                           std::span<const gpu_types::SmaaWeightsStory> weights, const gpu_types::SmaaBlendStory& blend,
                           const gpu_types::SmaaEdgesPush& push);

}  // namespace subpixel::replay
