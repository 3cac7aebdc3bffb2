#include "replay/story.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "replay/frame/pixel_story.hpp"
#include "replay/frame/run_frame.hpp"
#include "replay/gpu/litmus.hpp"
#include "replay/reference/reference.hpp"
#include "replay/results/limits.hpp"
#include "replay/single_frame.hpp"
#include "replay/techniques/complete_technique.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

// Those asked for, then `msaa` with as many samples as the first has, where it can.
std::vector<TechniqueSetting> settings_of(const StoryJob& job) {
  if (job.techniques.empty()) throw UsageError("technique", "none is named", "--technique");
  kSamplesLimit.require(job.samples);
  kReferenceSamplesLimit.require(job.reference_samples);
  if (job.point_lights) kPointLightsLimit.require(*job.point_lights);
  std::vector<TechniqueRequest> wanted;
  std::vector<TechniqueSetting> settings;
  const auto add = [&](const TechniqueSetting& setting) {
    if (add_once(wanted, setting)) settings.push_back(setting);
  };
  for (const TechniqueRequest& request : job.techniques) add(complete_technique(request, job.samples));
  add(complete_technique({"msaa", {}}, settings.front().parameters->samples));
  return settings;
}

capture::Capture read_frame(const StoryJob& job, const std::vector<TechniqueSetting>& settings) {
  std::uint32_t history = 0;
  for (const TechniqueSetting& setting : settings)
    if (const auto* temporal = dynamic_cast<const TemporalParameters*>(setting.parameters.get()))
      history = std::max(history, temporal->history);
  return load_frame(job.capture, job.frame, history, job.point_lights);
}

FrameChoice choice_of(const StoryJob& job, const capture::Capture& capture, std::uint32_t limit) {
  const FrameChoice choice = choose_size(capture, job.frame, job.width, job.height, limit);
  if (job.x >= choice.width || job.y >= choice.height)
    throw UsageError(
        "pixel", fmt::format("{},{} is not within 0,0 and {},{}", job.x, job.y, choice.width - 1, choice.height - 1),
        "--at");
  return choice;
}

json technique_story(FrameScene& scene, const TechniqueSetting& setting, glm::uvec2 pixel) {
  PixelStory story(pixel);
  RecordedFrame recorded(scene, setting, &story);
  recorded.run();
  json told = recorded.story();
  told["technique"] = setting.technique->name;
  told["parameters"] = setting.values;
  return told;
}

json reference_story(gpu::Device& device, GpuScene& scene, const StoryJob& job, const TechniqueSetting& setting) {
  PixelReference told{{job.x, job.y}, {}};
  ReferenceOptions options;
  options.samples = job.reference_samples;
  options.shading_model = static_cast<std::uint32_t>(setting.parameters->shading);
  options.tone_map_samples = setting.parameters->resolve == Resolve::tone_mapped;
  options.story = &told;
  const ReferenceImage image = render_reference(device, scene, options);
  json shadings = json::array();
  for (const PixelShading& one : told.shadings) {
    const TriangleSource source = triangle_source(scene, one.first_index, one.instance);
    shadings.push_back({{"turn", one.turn},
                        {"at", {one.at.x - 0.5f, one.at.y - 0.5f}},
                        {"samples", std::popcount(one.samples)},
                        {"triangle",
                         {{"draw", source.draw},
                          {"instance", source.instance},
                          {"triangle", source.triangle},
                          {"material", one.material},
                          {"material_name", scene.capture().materials[one.material].name}}},
                        {"radiance", {one.radiance.x, one.radiance.y, one.radiance.z}}});
  }
  const std::size_t p = 3 * (std::size_t{job.y} * image.linear.width + job.x);
  const auto three = [p](const Image& from) { return json{from.pixels[p], from.pixels[p + 1], from.pixels[p + 2]}; };
  return {{"samples", job.reference_samples},
          {"shadings", shadings},
          {"result", {{"radiance", three(image.linear)}, {"display", three(image.display)}}}};
}

}  // namespace

json tell_pixel(const StoryJob& job, const std::string& device_name) {
  const std::vector<TechniqueSetting> settings = settings_of(job);
  capture::Capture capture = read_frame(job, settings);
  gpu::DeviceOptions options;
  options.device = device_name;
  gpu::Device device(options);
  const FrameChoice choice = choice_of(job, capture, device.info().max_image_dimension);
  gpu::require_ordered_access(device);
  json story{{"capture", capture.metadata.title},
             {"frame", job.frame},
             {"size", {choice.width, choice.height}},
             {"pixel", {job.x, job.y}},
             {"device", device.info().device}};
  FrameScene scene(device, std::move(capture), SceneOptions{.point_lights = job.point_lights}, choice);
  for (const TechniqueSetting& setting : settings)
    story["stories"].push_back(technique_story(scene, setting, {job.x, job.y}));
  story["reference"] = nullptr;
  if (job.reference_samples > 0) story["reference"] = reference_story(device, scene.scene, job, settings.front());
  return story;
}

}  // namespace subpixel::replay
