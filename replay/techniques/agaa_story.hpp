// How one pixel's aggregates come to be, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "replay/frame/pixel_story.hpp"
#include "shaders/techniques/agaa/story_interface.h"

namespace subpixel::replay {

struct AgaaForm {
  std::uint32_t samples = 8, aggregates = 2, words = 4;  // of an aggregate
  float separation = 0;
};

// The samples and seeds of the clustering; null where the pixel shows one triangle or there is one aggregate, which
// takes none.
nlohmann::json agaa_definition(const AgaaForm& form, std::span<const gpu_types::AgaaDefinition> definition);
// What was done with each of the story's fragments: those that do not show, the seeds of aggregates, what the others
// add.
nlohmann::json agaa_steps(const PixelStory& story, const AgaaForm& form,
                          std::span<const gpu_types::AgaaDefinition> definition,
                          std::span<const gpu_types::AgaaPart> parts);
// The aggregates.
nlohmann::json agaa_surfaces(const PixelStory& story, const AgaaForm& form, std::span<const gpu_types::AgaaPart> parts);

}  // namespace subpixel::replay
