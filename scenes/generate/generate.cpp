#include "scenes/generate/generate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/error.hpp"
#include "capture_format/limits.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/generate/scenes.hpp"

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
    Scene{{"plant",
           "power plant: a maze of pipes, valves, grated walkways, ladders and railings, sun and 32 point lights"},
          [](const GenerateOptions& options) { return plant(options); }},
    Scene{{"cathedral", "nave of columns, arches and ribs with stained windows and a tiled floor, sun and 32 lamps"},
          [](const GenerateOptions& options) { return cathedral(options); }},
    Scene{{"triangle", "one triangle", SceneGroup::small}, triangle},
    Scene{{"cube", "a closed mesh of 12 triangles, turned so that three faces show", SceneGroup::small}, cube},
    Scene{{"quads", "overlapping rectangles at three depths, one alpha-tested, one emissive", SceneGroup::small},
          quads},
    Scene{{"spheres", "grid of spheres, metallic from bottom to top and rough from left to right", SceneGroup::small},
          spheres},
    Scene{{"agaa_correlation",
           "sunlit leaves before a red wall in shadow: what filtering colour and shadow apart gets wrong",
           SceneGroup::small},
          agaa_correlation},
    Scene{{"agaa_hairs", "thin shiny hairs: the same for normals on an arc", SceneGroup::small}, agaa_hairs},
    Scene{{"agaa_railings", "railings of square bars: the same for normals of two directions", SceneGroup::small},
          agaa_railings},
};

void require(bool holds, std::string_view parameter, const std::string& why) {
  if (!holds) throw UsageError("can't generate the scene", why, std::string(parameter));
}

}  // namespace

std::vector<SceneInfo> list_scenes() {
  std::vector<SceneInfo> list;
  list.reserve(std::size(kScenes) + hard_cases().size());
  for (const Scene& scene : kScenes) list.push_back(scene.info);
  for (const HardCase& hard : hard_cases())
    list.push_back({hard.name, hard.description, SceneGroup::hard, hard.expectation, 2, hard.width, hard.height});
  return list;
}

SceneInfo find_scene(std::string_view name) {
  std::string known;
  for (const SceneInfo& scene : list_scenes()) {
    if (scene.name == name) return scene;
    known += (known.empty() ? "" : ", ") + std::string(scene.name);
  }
  throw UsageError(fmt::format("unknown scene '{}'", name), "the scenes are " + known, "");
}

Capture generate(std::string_view name, const GenerateOptions& options) {
  find_scene(name);
  const auto require_range = [](std::string_view parameter, auto value, auto low, auto high) {
    require(value >= low && value <= high, parameter, fmt::format("{} is outside {} to {}", value, low, high));
  };
  require_range("frames", options.frames, 1u, kMaxFrames);
  require_range("width", options.width, 1u, kMaxFrameSide);
  require_range("height", options.height, 1u, kMaxFrameSide);
  require_range("density", options.density, 0.001, 100.0);
  const auto scene = std::find_if(kScenes.begin(), kScenes.end(), [&](const Scene& s) { return s.info.name == name; });
  if (scene != kScenes.end()) return scene->make(options);
  const auto cases = hard_cases();
  return std::find_if(cases.begin(), cases.end(), [&](const HardCase& hard) { return hard.name == name; })
      ->make(options);
}

}  // namespace subpixel::capture
