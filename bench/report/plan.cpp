#include "bench/report/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "replay/techniques/registry.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::report {
namespace {

using replay::ParameterValues;
using replay::Technique;
using replay::TechniqueRequest;

constexpr std::array<std::string_view, 10> kScenes{"grass", "fur",    "tubes", "bamboo",    "foliage",
                                                   "city",  "arcade", "plant", "cathedral", "park"};
constexpr std::array<std::string_view, 2> kQuickScenes{"city", "arcade"};
// Where each publication looked: stand-ins for its scenes (docs/scenes.md), at its size, of which the park is left out
// except for the times of linked lists: it is the one of millions of triangles.
constexpr std::array<std::string_view, 8> kHdScenes{"grass",   "arcade", "plant", "city",
                                                    "foliage", "bamboo", "tubes", "fur"};
constexpr std::array<std::string_view, 5> kFullHdScenes{"city", "bamboo", "grass", "arcade", "cathedral"};
// Table 1 of Crassin et al.
constexpr std::array<std::string_view, 5> kAggregateScenes{"city", "foliage", "bamboo", "tubes", "fur"};
// Few, more and many triangles, for table 2 of Fridvalszky and Toth.
constexpr std::array<std::string_view, 3> kListScenes{"city", "foliage", "park"};
constexpr std::array<std::string_view, 3> kFlickerScenes{"city", "bamboo", "grass"};
// Schied and Dachsbacher 2015: a hall, streets, and a field for what is not like them.
constexpr std::array<std::string_view, 3> kUltraHdScenes{"arcade", "city", "grass"};

constexpr std::string_view kSweeps =
    "noaa,msaa:samples=8|4,fxaa,smaa,taa,forward:samples=8|64,simple_complex:samples=8|4,sbaa:surfaces=2|4|6,"
    "streaming:surfaces=2..4,streaming:samples=4,streaming:discard=resolved,streaming:occlusion=depth_test,"
    "linked_list:samples=8|4,agaa:aggregates=1..4,agaa:samples=16,agaa:ndf=sggx,"
    "dcaa:surfaces=2|4|8,dcaa:second_merge=nearest,hybrid:surfaces=2|4";
// Kerzner and Salvi 2014, Crassin et al. 2016. Where agaa is held against simple_complex, that is set to lose nothing:
// any difference of normals within a pixel makes it complex.
constexpr std::string_view kHd =
    "msaa:samples=8|32,forward:samples=8,simple_complex:samples=8|4,simple_complex:samples=8:normal_threshold=1,"
    "sbaa:surfaces=2|4|6,streaming:surfaces=2..4,streaming:samples=4,agaa:aggregates=2,agaa:samples=32,"
    "agaa:aggregates=3:samples=4|8|32,agaa:ndf=sggx";
// Wang et al. 2015; Fridvalszky and Toth 2020 for the lists' blocks.
constexpr std::string_view kFullHd =
    "msaa:samples=8,forward:samples=8,sbaa:surfaces=4,dcaa:surfaces=2|4|8,dcaa:second_merge=nearest,linked_list:"
    "samples=8,hybrid";
constexpr std::string_view kDensities = "simple_complex:samples=8|4,streaming:samples=8|4";
constexpr std::string_view kAggregateTimes =
    "simple_complex:samples=8|32:normal_threshold=1:shading=blinn_phong|ggx,agaa:samples=8|32:shading=blinn_phong|ggx";
constexpr std::string_view kListTimes =
    "noaa,msaa:samples=4|8,msaa:samples=4|8:prepass=false,linked_list:samples=4|8,linked_list:samples=4|8:pool=0";
constexpr std::string_view kFlicker = "noaa,taa,msaa:samples=8,forward:samples=8,sbaa:surfaces=2|4,agaa,dcaa,hybrid";

template <class Names>
bool contains(const Names& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

// `samples` stays what each technique has as its default: msaa and the like 8, dcaa 64.
std::vector<TechniqueRequest> settings(std::string_view list, bool every_technique) {
  std::vector<TechniqueRequest> requests = replay::parse_technique_list(list);
  if (every_technique) {
    for (const Technique* technique : replay::techniques()) {
      if (std::ranges::find(requests, technique->name, &TechniqueRequest::technique) == requests.end())
        requests.push_back({std::string(technique->name), {}});
    }
  }
  for (TechniqueRequest& request : requests)
    request.parameters = replay::find_technique(request.technique).with(request.parameters).values;
  return requests;
}

ImagePair pair_of(std::string_view test, std::string_view base) {
  return {settings(test, false).front(), settings(base, false).front()};
}

// What is said to look alike, and the yardstick beside it.
std::vector<ImagePair> look_alikes(RunKind kind) {
  std::vector<ImagePair> pairs;
  const auto add = [&](std::string_view test, std::string_view base) { pairs.push_back(pair_of(test, base)); };
  add("streaming", "forward");
  add("simple_complex", "forward");
  add("streaming", "streaming:surfaces=4");
  add("streaming:surfaces=2", "forward");
  for (const char* test : {"agaa", "sbaa:surfaces=2", "sbaa:surfaces=4", "simple_complex"}) add(test, "msaa");
  if (kind == RunKind::paper) {
    add("agaa:samples=32", "msaa:samples=32");
    add("msaa", "msaa:samples=32");
  } else {
    add("dcaa", "forward:samples=64");
    add("forward", "forward:samples=64");
  }
  return pairs;
}

}  // namespace

std::string pair_name(const ImagePair& pair) {
  return setting_name(pair.test.technique, pair.test.parameters) + " / " +
         setting_name(pair.base.technique, pair.base.parameters);
}

std::string RunPlan::name() const {
  const std::string lights = point_lights ? fmt::format("_lights{}", *point_lights) : "";
  const std::string several = frames > 1 ? fmt::format("_frames{}", frames) : "";
  return fmt::format("{}_{}x{}{}{}", scene, width, height, lights, several);
}

std::vector<RunPlan> make_plan(const PlanOptions& options) {
  std::vector<std::string> scenes = options.scenes;
  if (scenes.empty() && options.quick) scenes.assign(kQuickScenes.begin(), kQuickScenes.end());
  if (scenes.empty()) scenes.assign(kScenes.begin(), kScenes.end());
  for (const std::string& scene : scenes)
    if (scene != "park") capture::find_scene(scene);

  const bool whole = options.techniques.empty();
  const std::uint32_t samples = options.quick ? 64 : 256;
  RunPlan sweep{.kind = RunKind::sweep,
                .width = 640,
                .height = 360,
                .reference_samples = samples,
                .repeat = 3,
                .techniques = settings(whole ? kSweeps : options.techniques, whole)};
  if (whole) sweep.pairs = look_alikes(RunKind::sweep);
  if (options.quick) std::tie(sweep.width, sweep.height) = std::pair(320u, 180u);
  if (options.width != 0) std::tie(sweep.width, sweep.height) = std::pair(options.width, options.height);

  std::vector<RunPlan> plan;
  const auto add = [&](const RunPlan& run, const std::string& scene) {
    plan.push_back(run);
    plan.back().scene = scene;
  };
  for (const std::string& scene : scenes) add(sweep, scene);
  if (!whole) return plan;

  // The quick form takes the publications' light counts at its one size.
  const auto sized = [&](RunPlan run, std::uint32_t width, std::uint32_t height) {
    std::tie(run.width, run.height) = options.quick ? std::pair(sweep.width, sweep.height) : std::pair(width, height);
    return run;
  };
  for (const std::string& scene : scenes) {
    if (!options.quick && contains(kHdScenes, scene)) {
      add({.kind = RunKind::paper,
           .width = 1280,
           .height = 720,
           .reference_samples = 128,
           .repeat = 3,
           .techniques = settings(kHd, false),
           .pairs = look_alikes(RunKind::paper)},
          scene);
    }
    // How far a field's density decides the share of lighting executions.
    if (!options.quick && scene == "grass") {
      for (const char* density : {"0.25", "0.5", "2"}) {
        add({.kind = RunKind::paper,
             .width = 1280,
             .height = 720,
             .repeat = 1,
             .techniques = settings(kDensities, false)},
            scene + "@" + density);
      }
    }
    // Errors and counts alone: times at this size are those of the lists.
    if (!options.quick && contains(kFullHdScenes, scene)) {
      add({.kind = RunKind::paper,
           .width = 1920,
           .height = 1080,
           .reference_samples = 128,
           .repeat = 1,
           .techniques = settings(kFullHd, false)},
          scene);
    }
    if (!options.quick && contains(kUltraHdScenes, scene)) {
      add({.kind = RunKind::paper, .width = 3840, .height = 2160, .repeat = 1, .techniques = settings("dais", false)},
          scene);
    }
    if (contains(kAggregateScenes, scene)) {
      // The fur ball has one light.
      const std::uint32_t lights = scene == "fur" ? 0 : 16;
      add(sized({.kind = RunKind::lights,
                 .point_lights = lights,
                 .every_light = true,
                 .repeat = 3,
                 .techniques = settings(kAggregateTimes, false)},
                1280, 720),
          scene);
    }
    if (contains(kListScenes, scene)) {
      for (const std::uint32_t lights : {5u, 50u}) {
        if (scene == "foliage" && lights != 5) continue;
        add(sized({.kind = RunKind::lights,
                   .point_lights = lights,
                   .every_light = true,
                   .repeat = 3,
                   .techniques = settings(kListTimes, false)},
                  1920, 1080),
            scene);
      }
    }
    if (!options.quick && contains(kFlickerScenes, scene)) {
      add({.kind = RunKind::frames,
           .width = 320,
           .height = 180,
           .reference_samples = 64,
           .repeat = 1,
           .techniques = settings(kFlicker, false),
           .frames = 16},
          scene);
    }
  }
  return plan;
}

std::string setting_name(const std::string& technique, const ParameterValues& parameters) {
  const Technique& registered = replay::find_technique(technique);
  std::string sweep, samples, others;
  for (const replay::Parameter& declared : registered.parameters) {
    const auto found = parameters.find(std::string(declared.name));
    if (found == parameters.end()) continue;
    const bool is_default = found->second == declared.default_value;
    const std::string value = found->second.is_string() ? found->second.get<std::string>() : found->second.dump();
    if (declared.name == "surfaces") {
      sweep = " S=" + value;
    } else if (declared.name == "aggregates") {
      sweep = " c=" + value;
    } else if (declared.name == "samples") {
      if (declared.allowed.size() > 1) samples = (is_default ? "?" : " ") + value + "x";
    } else if (!is_default) {
      others += fmt::format(" {}={}", declared.name, value);
    }
  }
  // The default number of samples goes without saying where there is something else to tell settings apart by.
  if (samples.starts_with('?')) samples = sweep.empty() ? " " + samples.substr(1) : "";
  return technique + sweep + samples + others;
}

}  // namespace subpixel::report
