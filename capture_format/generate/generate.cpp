#include "capture_format/generate/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "capture_format/error.hpp"
#include "capture_format/generate/scenes.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {
namespace {

struct Scene {
  SceneInfo info;
  Capture (*make)(const GenerateOptions&);
};

constexpr std::array kScenes{
    Scene{{"grass", "field of thin curved blades on hilly ground, sun and 32 point lights, about 260k triangles"},
          [](const GenerateOptions& options) { return grass(options); }},
    Scene{{"city", "street of buildings with window frames, railings, lamp posts and wires, sun and 32 point lights"},
          [](const GenerateOptions& options) { return city(options); }},
    Scene{{"fur", "ball of fur: overlapping fibres of half a pixel, sun and 32 point lights"},
          [](const GenerateOptions& options) { return fur(options); }},
    Scene{{"tubes", "tangle of bent metal tubes over a floor, sun and 32 point lights"},
          [](const GenerateOptions& options) { return tubes(options); }},
    Scene{{"bamboo", "grove of bamboo with branches and modelled leaves, sun and 32 point lights"},
          [](const GenerateOptions& options) { return bamboo(options); }},
    Scene{{"foliage", "trees of alpha-tested leaf cards, sun and 32 point lights"},
          [](const GenerateOptions& options) { return foliage(options); }},
    Scene{{"arcade", "hall of columns and arches in brick and stone, sun and 32 lamps on chains"},
          [](const GenerateOptions& options) { return arcade(options); }},
    Scene{{"triangle", "one triangle"}, triangle},
    Scene{{"empty", "frames without a draw call"}, empty},
    Scene{{"cube", "a closed mesh of 12 triangles, turned so that three faces show"}, cube},
    Scene{{"quads", "overlapping rectangles at three depths, one alpha-tested, one emissive"}, quads},
    Scene{{"spheres", "grid of spheres, metallic from bottom to top and rough from left to right"}, spheres},
    Scene{{"streaming_normals", "steep pleats: what merging without the condition on normals gets wrong"},
          streaming_normals},
    Scene{{"streaming_depth", "slats before a finely meshed wall: the same for depths"}, streaming_depth},
    Scene{{"streaming_coverage", "mats on a floor at a grazing angle: the same for coverage"}, streaming_coverage},
    Scene{{"streaming_angle", "light strips beside dark ones at 30 degrees: a merge that all conditions allow"},
          streaming_angle},
};

void require(bool holds, std::string_view parameter, const std::string& why) {
  if (!holds) throw UsageError("can't generate the scene", why, std::string(parameter));
}

}  // namespace

std::vector<SceneInfo> list_scenes() {
  std::vector<SceneInfo> list;
  list.reserve(kScenes.size());
  for (const Scene& scene : kScenes) list.push_back(scene.info);
  return list;
}

Capture generate(std::string_view name, const GenerateOptions& options) {
  const auto scene = std::find_if(kScenes.begin(), kScenes.end(), [&](const Scene& s) { return s.info.name == name; });
  if (scene == kScenes.end()) {
    std::string known;
    for (const Scene& s : kScenes) known += (known.empty() ? "" : ", ") + std::string(s.info.name);
    throw UsageError(fmt::format("unknown scene '{}'", name), "the scenes are " + known, "");
  }
  const auto require_range = [](std::string_view parameter, auto value, auto low, auto high) {
    require(value >= low && value <= high, parameter, fmt::format("{} is outside {} to {}", value, low, high));
  };
  require_range("frames", options.frames, 1u, kMaxFrames);
  require_range("width", options.width, 1u, kMaxFrameSide);
  require_range("height", options.height, 1u, kMaxFrameSide);
  require_range("density", options.density, 0.001, 100.0);
  return scene->make(options);
}

}  // namespace subpixel::capture
