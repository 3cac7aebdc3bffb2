#include "replay/results/worker_protocol.hpp"

#include "base/json_fields.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

constexpr std::uint32_t kMaxRounds = 1000;

json options_to_json(const ReplayOptions& options) {
  json techniques = json::array();
  for (const TechniqueRequest& request : options.techniques) {
    json parameters = json::object();
    for (const auto& [name, value] : request.parameters) parameters[name] = value;
    techniques.push_back({{"technique", request.technique}, {"parameters", parameters}});
  }
  json skip = json::array();
  for (const auto& [frame, technique] : options.skip) skip.push_back(json::array({frame, technique}));
  json out = {{"techniques", techniques},
              {"samples", options.samples},
              {"frames", nullptr},
              {"width", options.width},
              {"height", options.height},
              {"repeat", options.repeat},
              {"reference_samples", options.reference_samples},
              {"point_lights", nullptr},
              {"skip", skip}};
  if (options.references_only) out["references_only"] = true;
  if (options.frames) out["frames"] = json::array({options.frames->first, options.frames->second});
  if (options.point_lights) out["point_lights"] = *options.point_lights;
  if (options.every_light) out["every_light"] = true;
  if (options.memory_mib > 0) out["memory_mib"] = options.memory_mib;
  if (options.rounds > 0) out["rounds"] = options.rounds;
  return out;
}

std::pair<std::uint32_t, std::uint32_t> pair_from(const JsonField& field) {
  if (field.array_size() != 2) field.fail("expected two numbers");
  return {field.element(0).u32(), field.element(1).u32()};
}

ReplayOptions options_from_field(const JsonField& field) {
  ReplayOptions options;
  const JsonField techniques = field.member("techniques");
  for (std::size_t i = 0; i < techniques.array_size(); ++i) {
    const JsonField entry = techniques.element(i);
    TechniqueRequest request;
    request.technique = entry.member("technique").text();
    const JsonField parameters = entry.member("parameters");
    for (const auto& item : parameters.object().items()) {
      if (!item.value().is_primitive()) parameters.member(item.key()).fail("expected a number, text or truth value");
      request.parameters[item.key()] = item.value();
    }
    options.techniques.push_back(std::move(request));
  }
  options.samples = field.member("samples").u32();
  if (field.has("frames") && !field.member("frames").raw().is_null()) {
    options.frames = pair_from(field.member("frames"));
    if (options.frames->first > options.frames->second) field.member("frames").fail("range runs backwards");
  }
  options.width = field.member("width").u32();
  options.height = field.member("height").u32();
  options.repeat = field.member("repeat").u32();
  options.reference_samples = field.member("reference_samples").u32();
  if (field.has("point_lights") && !field.member("point_lights").raw().is_null()) {
    options.point_lights = field.member("point_lights").u32();
  }
  if (field.has("every_light")) options.every_light = field.member("every_light").truth();
  if (field.has("memory_mib")) options.memory_mib = field.member("memory_mib").u32();
  if (field.has("rounds")) {
    options.rounds = field.member("rounds").u32();
    if (options.rounds > kMaxRounds) field.member("rounds").fail("there are too many");
  }
  if (field.has("skip")) {
    const JsonField skip = field.member("skip");
    for (std::size_t i = 0; i < skip.array_size(); ++i) options.skip.push_back(pair_from(skip.element(i)));
  }
  if (field.has("references_only")) options.references_only = field.member("references_only").truth();
  return options;
}

}  // namespace

std::optional<std::pair<std::uint32_t, std::uint32_t>> frames_of(const ReplayOptions& options,
                                                                 std::size_t frame_count) {
  if (frame_count == 0) return std::nullopt;
  const auto all = std::pair(0u, static_cast<std::uint32_t>(frame_count - 1));
  const auto [first, last] = options.frames.value_or(all);
  if (first > last || last > all.second) return std::nullopt;
  return std::pair(first, last);
}

json to_json(const ReplayJob& job) {
  return {{"capture", job.capture.string()},
          {"out_dir", job.out_dir.string()},
          {"cache_dir", job.cache_dir.string()},
          {"options", options_to_json(job.options)}};
}

ReplayJob replay_job_from_json(const json& document) {
  const JsonField top(document, "worker job");
  ReplayJob job;
  job.capture = top.member("capture").text();
  job.out_dir = top.member("out_dir").text();
  job.cache_dir = top.member("cache_dir").text();
  job.options = options_from_field(top.member("options"));
  return job;
}

}  // namespace subpixel::replay
