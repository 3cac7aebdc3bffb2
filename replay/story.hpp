// One pixel's story: what techniques and the reference make of it, for the command line, the service and the page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "replay/results/parameters.hpp"

namespace subpixel::replay {

struct StoryJob {
  std::filesystem::path capture;
  std::vector<TechniqueRequest> techniques;  // `msaa` is told beside them
  std::uint32_t samples = 8;                 // of those that don't name theirs
  std::uint32_t frame = 0, x = 0, y = 0;
  std::uint32_t width = 0, height = 0;        // pixels; 0: as the frame was recorded
  std::uint32_t reference_samples = 64;       // 0: no reference
  std::optional<std::uint32_t> point_lights;  // exactly this many, as of a run; as recorded when absent
};

// docs/pixel_story.md describes it. `device` as ReplayInspection has it. Throws UsageError (technique, frame, pixel,
// size, lights), InputError (capture) and DeviceError.
nlohmann::json tell_pixel(const StoryJob& job, const std::string& device = {});

// The same for people.
std::string story_text(const nlohmann::json& story);

}  // namespace subpixel::replay
