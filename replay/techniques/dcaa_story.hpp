// What the merging of one pixel does, step by step, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/dcaa_passes.hpp"
#include "shaders/techniques/dcaa/story_interface.h"

namespace subpixel::replay {

// What was done with each of the story's fragments. `listed`: their entries in the lists after the merge.
nlohmann::json dcaa_steps(const PixelStory& story, const DcaaForm& form, std::span<const gpu_types::DcaaStep> steps,
                          std::span<const glm::uvec4> listed);
// What was kept in the end.
nlohmann::json dcaa_surfaces(const DcaaForm& form, std::span<const gpu_types::DcaaStep> steps);

}  // namespace subpixel::replay
