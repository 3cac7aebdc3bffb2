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

constexpr std::array<std::string_view, 8> kScenes{"grass",   "fur",  "tubes",  "bamboo",
                                                  "foliage", "city", "arcade", "park"};
constexpr std::array<std::string_view, 2> kQuickScenes{"city", "arcade"};
constexpr std::array<std::string_view, 3> kSizeScenes{"grass", "city", "park"};
// Stand-ins for the five scenes of table 1 of Crassin et al.
constexpr std::array<std::string_view, 5> kAggregateScenes{"city", "foliage", "bamboo", "tubes", "fur"};
// A scene of few and one of many triangles, for table 2 of Fridvalszky and Toth.
constexpr std::array<std::string_view, 2> kListScenes{"city", "park"};

constexpr std::string_view kSweeps =
    "noaa,msaa:samples=8|4|16,fxaa,forward:samples=8|4,simple_complex:samples=8|4,sbaa:surfaces=2|4|6,sbaa:mode=id,"
    "streaming:surfaces=1..4,streaming:samples=4,streaming:occlusion=depth_test,linked_list:samples=8|4,"
    "agaa:aggregates=1..4,agaa:samples=16,agaa:aggregates=3:samples=4|16,agaa:ndf=sggx,"
    "dcaa:surfaces=2|4|8,dcaa:samples=16|32,hybrid:surfaces=2|3|4|8,hybrid:normals=mean,hybrid:second_merge="
    "overlapping";
constexpr std::string_view kMain =
    "noaa,msaa:samples=8|4,fxaa,forward,simple_complex,sbaa,streaming,linked_list:samples=8|4,agaa,dcaa,hybrid";
constexpr std::string_view kAggregateTimes =
    "simple_complex:samples=8,agaa:samples=8,simple_complex:samples=32,agaa:samples=32";
constexpr std::string_view kListTimes = "noaa,msaa:samples=4|8,linked_list:samples=4|8,linked_list:samples=4|8:pool=0";

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

}  // namespace

std::string RunPlan::name() const {
  const std::string lights = point_lights ? fmt::format("_lights{}", *point_lights) : "";
  return fmt::format("{}_{}x{}{}", scene, width, height, lights);
}

std::vector<RunPlan> make_plan(const PlanOptions& options) {
  std::vector<std::string> scenes = options.scenes;
  if (scenes.empty() && options.quick) scenes.assign(kQuickScenes.begin(), kQuickScenes.end());
  if (scenes.empty()) scenes.assign(kScenes.begin(), kScenes.end());
  for (const std::string& scene : scenes)
    if (scene != "park") capture::find_scene(scene);

  constexpr std::uint32_t repeat = 3;
  const std::uint32_t samples = options.quick ? 64 : 256;
  RunPlan sweep{RunKind::sweep,
                "",
                640,
                360,
                std::nullopt,
                samples,
                repeat,
                settings(options.techniques.empty() ? kSweeps : options.techniques, options.techniques.empty())};
  if (options.quick) std::tie(sweep.width, sweep.height) = std::pair(320u, 180u);
  if (options.width != 0) std::tie(sweep.width, sweep.height) = std::pair(options.width, options.height);

  std::vector<RunPlan> plan;
  const auto add = [&](const RunPlan& run, const std::string& scene) {
    plan.push_back(run);
    plan.back().scene = scene;
  };
  for (const std::string& scene : scenes) add(sweep, scene);
  if (!options.techniques.empty()) return plan;

  // The quick form takes the publications' light counts at its one size.
  const auto [width, height] = options.quick ? std::pair(sweep.width, sweep.height) : std::pair(1280u, 720u);
  if (!options.quick) {
    const RunPlan small{RunKind::size, "", 320, 180, std::nullopt, samples, repeat, settings(kMain, false)};
    const RunPlan large{RunKind::size, "", width, height, std::nullopt, samples / 2, repeat, settings(kMain, false)};
    for (const std::string& scene : scenes)
      if (contains(kSizeScenes, scene)) add(small, scene), add(large, scene);
  }
  for (const std::string& scene : scenes) {
    if (contains(kAggregateScenes, scene))
      add({RunKind::lights, "", width, height, 16, 0, repeat, settings(kAggregateTimes, false)}, scene);
    if (!contains(kListScenes, scene)) continue;
    for (const std::uint32_t lights : {5u, 50u})
      add({RunKind::lights, "", width, height, lights, 0, repeat, settings(kListTimes, false)}, scene);
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
