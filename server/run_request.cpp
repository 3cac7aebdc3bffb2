#include "server/run_request.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/json_fields.hpp"
#include "base/printable.hpp"
#include "replay/results/limits.hpp"
#include "replay/techniques/complete_technique.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::string_view kWhat = "run request";

void require_technique_count(std::size_t count, const JsonField& list) {
  if (replay::kTechniquesLimit.holds(count)) return;
  const std::string refusal = replay::kTechniquesLimit.refusal(std::to_string(count));
  list.fail(count == 0 ? "expected at least one technique: " + refusal : refusal);
}

replay::TechniqueRequest parse_technique(const JsonField& entry, std::size_t index) {
  check_names(entry, {"technique", "parameters"}, std::string(kWhat), fmt::format("techniques[{}]", index));
  replay::ParameterValues given;
  if (entry.has("parameters")) {
    const JsonField parameters = entry.member("parameters");
    for (const auto& item : parameters.object().items()) {
      const JsonField value = parameters.member(item.key());
      if (!item.value().is_primitive() || item.value().is_null()) value.fail("expected a number, text or truth value");
      given[item.key()] = item.value();
    }
  }
  return {entry.member("technique").text(), std::move(given)};
}

// An entry is one technique, or a text in the command line's syntax, whose sweeps make it several.
std::vector<replay::TechniqueRequest> parse_techniques(const JsonField& list, std::uint32_t samples) {
  if (list.array_size() == 0) require_technique_count(0, list);
  std::vector<replay::TechniqueRequest> requests;
  const auto add = [&](const replay::TechniqueRequest& request, const JsonField& entry) {
    if (!add_once(requests, replay::complete_technique(request, samples))) {
      entry.fail("the same technique with the same parameters is asked for twice");
    }
    require_technique_count(requests.size(), list);
  };
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    const JsonField entry = list.element(i);
    if (entry.raw().is_string()) {
      for (const replay::TechniqueRequest& request : replay::parse_technique_list(entry.text())) add(request, entry);
    } else {
      add(parse_technique(entry, i), entry);
    }
  }
  return requests;
}

}  // namespace

RunRequest parse_run_request(std::string_view body) {
  const json document = parse_json_document(body, std::string(kWhat), "the body");
  const JsonField top(document, std::string(kWhat));
  check_names(top,
              {"capture", "techniques", "samples", "frames", "width", "height", "repeat", "reference_samples",
               "point_lights", "every_light", "memory_mib", "priority", "retries"},
              std::string(kWhat), "top level");
  RunRequest request;
  request.capture = top.member("capture").text();
  replay::ReplayOptions& options = request.options;
  options.samples = limited(top, replay::kSamplesLimit, options.samples);
  options.techniques = parse_techniques(top.member("techniques"), options.samples);
  options.width = limited(top, replay::kWidthLimit, 0);
  options.height = limited(top, replay::kHeightLimit, 0);
  if ((options.width == 0) != (options.height == 0)) {
    throw InputError(std::string(kWhat), "width and height are given together or not at all", "width, height");
  }
  options.repeat = limited(top, replay::kRepeatLimit, options.repeat);
  options.reference_samples = limited(top, replay::kReferenceSamplesLimit, options.reference_samples);
  if (top.has("point_lights") && !top.member("point_lights").raw().is_null()) {
    options.point_lights = limited(top, replay::kPointLightsLimit, 0);
  }
  if (top.has("every_light")) options.every_light = top.member("every_light").truth();
  options.memory_mib = limited(top, replay::kMemoryLimit, 0);
  if (top.has("frames") && !top.member("frames").raw().is_null()) {
    const JsonField frames = top.member("frames");
    if (frames.array_size() != 2) frames.fail("expected [first, last]");
    options.frames = {frames.element(0).u32(), frames.element(1).u32()};
  }
  request.place.priority = limited(top, replay::kPriorityLimit, request.place.priority);
  request.place.retries = limited(top, replay::kRetriesLimit, request.place.retries);
  return request;
}

std::uint64_t resolve_frames(replay::ReplayOptions& options, std::uint32_t frame_count) {
  if (frame_count == 0) throw InputError(std::string(kWhat), "the capture has no frames", "capture");
  const auto wanted = replay::frames_of(options, frame_count);
  if (!wanted) {
    throw InputError(std::string(kWhat),
                     fmt::format("expected first <= last <= {}, got [{}, {}]", frame_count - 1, options.frames->first,
                                 options.frames->second),
                     "frames");
  }
  options.frames = wanted;
  const auto [first, last] = *wanted;
  const std::uint64_t results = (std::uint64_t{last} - first + 1) * options.techniques.size();
  if (!replay::kResultsLimit.holds(results)) {
    throw InputError(std::string(kWhat), "results: " + replay::kResultsLimit.refusal(std::to_string(results)),
                     "frames, techniques");
  }
  return results;
}

replay::ReplayOptions thumbnail_options() {
  replay::ReplayOptions options;
  options.techniques.push_back({"noaa", replay::find_technique("noaa").with().values});
  options.frames = {0, 0};
  options.width = 320;
  options.height = 180;
  options.repeat = 1;
  options.reference_samples = 0;
  return options;
}

}  // namespace subpixel::server
