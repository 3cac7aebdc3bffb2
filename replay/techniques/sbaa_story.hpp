// How one pixel's surfaces of `sbaa` come to be, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "replay/frame/pixel_story.hpp"
#include "shaders/techniques/sbaa/story_interface.h"

namespace subpixel::replay {

struct SbaaForm {
  std::uint32_t samples = 8, surfaces = 4;
  bool merges = true;
  float cosine = 0;  // of normals, above which groups merge
};

// What was done with each of the story's fragments, in this order: those that do not show; the groups of samples that
// the others are in; which of the surfaces found are kept.
nlohmann::json sbaa_steps(const PixelStory& story, const SbaaForm& form, std::span<const gpu_types::SbaaStep> steps,
                          std::span<const gpu_types::SbaaKept> kept);
// What is kept: the surfaces that are lit.
nlohmann::json sbaa_surfaces(const PixelStory& story, const SbaaForm& form, std::span<const gpu_types::SbaaStep> steps,
                             std::span<const gpu_types::SbaaKept> kept);

}  // namespace subpixel::replay
