// Procedural scenes. Each is a pure function of its options: the same bytes on every machine.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct GenerateOptions {
  std::uint32_t frames = 10;                 // 1 to kMaxFrames, 1/30 s apart
  std::uint32_t width = 1280, height = 720;  // pixels
  std::uint64_t seed = 1;
  double density =
      1.0;  // 0.001 to 100: factor on the number of blades, leaves, fibres, ...; scenes without any ignore it
};

enum class SceneGroup { scene, small, hard };

struct SceneInfo {
  std::string_view name;
  std::string_view description;  // one line
  SceneGroup group = SceneGroup::scene;
  std::string_view expectation = {};  // hard cases: what every working technique shows, one line
  // Frames and size when none are asked for.
  std::uint32_t frames = 10, width = 1280, height = 720;
};

// All scenes, in the order they are listed to users, group by group.
std::vector<SceneInfo> list_scenes();
// The one of that name. Throws UsageError for an unknown name (the message lists the known ones).
SceneInfo find_scene(std::string_view name);

// The scene's capture. Throws UsageError for an unknown name and for options out of range.
Capture generate(std::string_view scene, const GenerateOptions& options = {});

}  // namespace subpixel::capture
