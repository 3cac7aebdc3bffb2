// What the filter of `fxaa` does to one pixel, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "shaders/techniques/fxaa/story_interface.h"

namespace subpixel::replay {

// Step after step, each with its numbers and a sentence: luma, contrast, direction, search, offset, blend.
nlohmann::json fxaa_filter(const gpu_types::FxaaStory& story, const gpu_types::FxaaPush& push);

}  // namespace subpixel::replay
