// What the compression of one pixel does, step by step, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/streaming.hpp"
#include "shaders/techniques/streaming/story_interface.h"

namespace subpixel::replay {

// What was done with each of the story's fragments.
nlohmann::json streaming_steps(const PixelStory& story, const StreamingParameters& parameters,
                               std::span<const gpu_types::StreamStep> steps);
// What was kept in the end, front to back.
nlohmann::json streaming_surfaces(const StreamingParameters& parameters, std::span<const gpu_types::StreamStep> steps);

}  // namespace subpixel::replay
