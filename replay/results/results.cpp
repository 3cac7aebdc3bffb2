#include "replay/results/results.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <set>

#include "base/json_fields.hpp"

namespace subpixel::replay {
namespace {

using nlohmann::json;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json error_to_json(const ImageError& error) {
  return {{"mse", number_or_null(error.mse)},
          {"psnr", number_or_null(error.psnr_db)},
          {"flip_mean", number_or_null(error.flip_mean)},
          {"flip_p99", number_or_null(error.flip_p99)},
          {"flip_max", number_or_null(error.flip_max)},
          {"hdr_rel_mse", number_or_null(error.hdr_rel_mse)},
          {"flicker", number_or_null(error.flicker)}};
}

ImageError error_from_json(const JsonField& field) {
  ImageError error;
  error.mse = field.member("mse").number_or_nan();
  error.psnr_db = field.member("psnr").number_or_nan();
  error.flip_mean = field.member("flip_mean").number_or_nan();
  error.flip_p99 = field.member("flip_p99").number_or_nan();
  error.flip_max = field.member("flip_max").number_or_nan();
  error.hdr_rel_mse = field.member("hdr_rel_mse").number_or_nan();
  error.flicker = field.member("flicker").number_or_nan();
  // Equal images have infinite PSNR, which JSON can't hold either; the MSE tells the two nulls apart.
  if (error.mse == 0 && std::isnan(error.psnr_db)) error.psnr_db = std::numeric_limits<double>::infinity();
  return error;
}

// A JSON object can hold a name once, so a pass that runs twice is told apart by its turn.
std::vector<std::string> unique_pass_names(const std::vector<PassTime>& passes) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const PassTime& pass : passes) {
    std::string name = pass.name;
    for (int turn = 2; !taken.insert(name).second; ++turn) name = fmt::format("{} {}", pass.name, turn);
    names.push_back(name);
  }
  return names;
}

json timing_to_json(const Timing& timing) {
  const std::vector<std::string> names = unique_pass_names(timing.passes);
  json passes = json::object();
  for (std::size_t i = 0; i < names.size(); ++i) passes[names[i]] = timing.passes[i].median_ms;
  return {{"total", timing.total_ms},
          {"passes", passes},
          {"pass_order", names},
          {"cold", timing.cold_ms},
          {"least", timing.least_ms},
          {"processor", timing.processor_ms},
          {"instructions", timing.instructions}};
}

Timing timing_from_json(const JsonField& field) {
  Timing timing;
  timing.total_ms = field.member("total").number();
  timing.cold_ms = field.has("cold") ? field.member("cold").number() : 0;
  timing.least_ms = field.has("least") ? field.member("least").number() : 0;
  timing.processor_ms = field.has("processor") ? field.member("processor").number() : 0;
  timing.instructions = field.has("instructions") ? field.member("instructions").u64() : 0;
  const JsonField passes = field.member("passes");
  if (field.has("pass_order")) {
    const JsonField order = field.member("pass_order");
    for (std::size_t i = 0; i < order.array_size(); ++i) {
      const std::string name = order.element(i).text();
      timing.passes.push_back({name, passes.member(name).number()});
    }
  } else {
    for (const auto& item : passes.object().items()) {
      timing.passes.push_back({item.key(), passes.member(item.key()).number()});
    }
  }
  return timing;
}

json memory_to_json(const Memory& memory) {
  return {{"paper_bytes_per_pixel", memory.paper_bytes_per_pixel},
          {"fitted_bytes_per_pixel", memory.fitted_bytes_per_pixel},
          {"paper_bytes", memory.paper_bytes},
          {"fitted_bytes", memory.fitted_bytes},
          {"allocated_bytes", memory.allocated_bytes},
          {"bands", memory.bands},
          {"peak_bytes", memory.peak_bytes}};
}

Memory memory_from_json(const JsonField& field) {
  Memory memory;
  memory.paper_bytes_per_pixel = field.member("paper_bytes_per_pixel").number();
  memory.fitted_bytes_per_pixel = field.member("fitted_bytes_per_pixel").number();
  memory.paper_bytes = field.member("paper_bytes").u64();
  memory.fitted_bytes = field.member("fitted_bytes").u64();
  memory.allocated_bytes = field.member("allocated_bytes").u64();
  memory.bands = field.has("bands") ? field.member("bands").u32() : 0;
  memory.peak_bytes = field.has("peak_bytes") ? field.member("peak_bytes").u64() : 0;
  return memory;
}

Shading shading_from_json(const JsonField& field) {
  Shading shading;
  shading.executions = field.member("executions").u64();
  shading.per_pixel_mean = field.member("per_pixel_mean").number();
  const JsonField histogram = field.member("histogram");
  for (std::size_t k = 0; k < histogram.array_size(); ++k) shading.histogram.push_back(histogram.element(k).u64());
  if (field.has("group_executions")) shading.group_executions = field.member("group_executions").u64();
  if (field.has("fragments")) {
    const JsonField fragments = field.member("fragments");
    for (const auto& item : fragments.object().items())
      shading.fragments[item.key()] = fragments.member(item.key()).u64();
  }
  return shading;
}

FrameResult frame_result_from_field(const JsonField& field) {
  FrameResult result;
  result.frame = field.member("frame").u32();
  result.technique = field.member("technique").text();
  const JsonField parameters = field.member("parameters");
  for (const auto& item : parameters.object().items()) {
    if (!item.value().is_primitive()) parameters.member(item.key()).fail("expected a number, text or truth value");
    result.parameters[item.key()] = item.value();
  }
  result.samples = field.member("samples").u32();
  result.width = field.member("width").u32();
  result.height = field.member("height").u32();
  result.ms = timing_from_json(field.member("ms"));
  result.ms.spread_ms = field.member("spread").number();
  result.memory = memory_from_json(field.member("memory"));
  result.shading = shading_from_json(field.member("shading"));
  result.error = error_from_json(field.member("error"));
  const JsonField counters = field.member("counters");
  for (const auto& item : counters.object().items()) {
    result.counters[item.key()] = counters.member(item.key()).u64();
  }
  const JsonField images = field.member("images");
  for (const auto& item : images.object().items()) result.images[item.key()] = images.member(item.key()).text();
  return result;
}

ResultsHead head_from_field(const JsonField& field) {
  ResultsHead head;
  head.capture_hash = field.member("capture_hash").text();
  head.capture_title = field.member("capture_title").text();
  head.driver = field.member("driver").text();
  head.driver_version = field.member("driver_version").text();
  head.device = field.member("device").text();
  head.cpu_model = field.member("cpu_model").text();
  head.build = field.member("build").text();
  head.date_utc = field.member("date_utc").text();
  head.width = field.member("width").u32();
  head.height = field.member("height").u32();
  head.repeat = field.member("repeat").u32();
  head.reference_samples = field.member("reference_samples").u32();
  head.point_lights = field.member("point_lights").u32();
  // Before there was a choice, every light was evaluated.
  head.every_light = !field.has("every_light") || field.member("every_light").truth();
  head.triangles_first_frame = field.member("triangles_first_frame").u64();
  head.memory_mib = field.has("memory_mib") ? field.member("memory_mib").u32() : 0;
  head.bands = field.has("bands") ? field.member("bands").u32() : 0;
  head.peak_bytes = field.has("peak_bytes") ? field.member("peak_bytes").u64() : 0;
  head.wall_s = field.member("wall_s").number();
  head.outside_gpu_s = field.member("outside_gpu_s").number();
  if (field.has("outside_parts_s")) {
    const JsonField parts = field.member("outside_parts_s");
    for (const auto& item : parts.object().items())
      head.outside_parts_s[item.key()] = parts.member(item.key()).number();
  }
  const JsonField features = field.member("features");
  for (std::size_t i = 0; i < features.array_size(); ++i) head.features.push_back(features.element(i).text());
  return head;
}

}  // namespace

ImageError::ImageError()
    : mse(nan_value),
      psnr_db(nan_value),
      flip_mean(nan_value),
      flip_p99(nan_value),
      flip_max(nan_value),
      hdr_rel_mse(nan_value),
      flicker(nan_value) {}

json to_json(const FrameResult& result) {
  json parameters = json::object();
  for (const auto& [name, value] : result.parameters) parameters[name] = value;
  return {{"frame", result.frame},
          {"technique", result.technique},
          {"parameters", parameters},
          {"samples", result.samples},
          {"width", result.width},
          {"height", result.height},
          {"ms", timing_to_json(result.ms)},
          {"spread", result.ms.spread_ms},
          {"memory", memory_to_json(result.memory)},
          {"shading",
           {{"executions", result.shading.executions},
            {"per_pixel_mean", result.shading.per_pixel_mean},
            {"histogram", result.shading.histogram},
            {"group_executions", result.shading.group_executions},
            {"fragments", json(result.shading.fragments)}}},
          {"error", error_to_json(result.error)},
          {"counters", json(result.counters)},
          {"images", json(result.images)}};
}

json to_json(const ResultsHead& head) {
  return {{"capture_hash", head.capture_hash},
          {"capture_title", head.capture_title},
          {"driver", head.driver},
          {"driver_version", head.driver_version},
          {"device", head.device},
          {"cpu_model", head.cpu_model},
          {"build", head.build},
          {"date_utc", head.date_utc},
          {"width", head.width},
          {"height", head.height},
          {"repeat", head.repeat},
          {"reference_samples", head.reference_samples},
          {"point_lights", head.point_lights},
          {"every_light", head.every_light},
          {"triangles_first_frame", head.triangles_first_frame},
          {"memory_mib", head.memory_mib},
          {"bands", head.bands},
          {"peak_bytes", head.peak_bytes},
          {"wall_s", head.wall_s},
          {"outside_gpu_s", head.outside_gpu_s},
          {"outside_parts_s", json(head.outside_parts_s)},
          {"features", head.features}};
}

json to_json(const Results& results) {
  json list = json::array();
  for (const FrameResult& result : results.results) list.push_back(to_json(result));
  return {{"head", to_json(results.head)}, {"results", std::move(list)}};
}

FrameResult frame_result_from_json(const json& document) {
  return frame_result_from_field(JsonField(document, "frame result"));
}

ResultsHead results_head_from_json(const json& document) {
  return head_from_field(JsonField(document, "results head"));
}

Results results_from_json(const json& document) {
  const JsonField top(document, "results");
  Results results;
  results.head = head_from_field(top.member("head"));
  const JsonField list = top.member("results");
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    results.results.push_back(frame_result_from_field(list.element(i)));
  }
  return results;
}

}  // namespace subpixel::replay
