// How `taa` accumulates one pixel, as JSON.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json_fwd.hpp>

#include "shaders/techniques/taa/story_interface.h"

namespace subpixel::replay {

// Step after step, each with its numbers and a sentence: motion, history, bounds, blend.
nlohmann::json taa_filter(const gpu_types::TaaStory& story, const gpu_types::TaaPush& push, glm::uvec2 pixel);

}  // namespace subpixel::replay
