#include "server/run_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "capture_format/error.hpp"
#include "replay/measure/json_fields.hpp"
#include "replay/techniques/technique.hpp"
#include "server/text.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;
using replay::JsonField;

constexpr std::string_view kWhat = "run request";
constexpr std::size_t kMaxTechniques = 256;
constexpr std::uint64_t kMaxResults = 100'000;

// Deeper than any valid request, far from the parser's stack.
constexpr int kMaxDepth = 16;

struct Range {
  std::uint32_t minimum, maximum;
};
constexpr Range kSamples{1, 64}, kSize{1, 16384}, kRepeat{1, 100}, kReferenceSamples{0, 65536}, kPointLights{0, 4096};

// Refuses what a name list does not hold, so that a misspelt option is not silently ignored.
void check_names(const JsonField& object, std::initializer_list<std::string_view> known, const std::string& where) {
  for (const auto& item : object.object().items()) {
    if (std::ranges::find(known, item.key()) == known.end()) {
      throw InputError(std::string(kWhat),
                       fmt::format("unknown field {} (valid: {})", printable(item.key(), 60), fmt::join(known, ", ")),
                       where);
    }
  }
}

std::uint32_t ranged(const JsonField& object, std::string_view name, Range range, std::uint32_t absent) {
  if (!object.has(name) || object.member(name).raw().is_null()) return absent;
  const JsonField field = object.member(name);
  const json& value = field.raw();
  // The full 64 bits are compared: a value that wraps into the range is out of it.
  const bool whole = value.is_number_unsigned() || (value.is_number_integer() && value.get<std::int64_t>() >= 0);
  const std::uint64_t number = whole ? value.get<std::uint64_t>() : 0;
  if (!whole || number < range.minimum || number > range.maximum) {
    field.fail(fmt::format("expected a whole number from {} to {}", range.minimum, range.maximum));
  }
  return static_cast<std::uint32_t>(number);
}

json parse_document(std::string_view body) {
  int depth = 0;
  const auto limit_depth = [&](int, json::parse_event_t event, json&) {
    if (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start) {
      if (++depth > kMaxDepth) throw InputError(std::string(kWhat), "the JSON is nested too deeply", "body");
    } else if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) {
      --depth;
    }
    return true;
  };
  try {
    return json::parse(body, limit_depth);
  } catch (const json::parse_error& error) {
    const std::size_t offset = std::min(error.byte > 0 ? error.byte - 1 : 0, body.size());
    const std::string_view before = body.substr(0, offset);
    const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    throw InputError(std::string(kWhat), "the body is no valid JSON",
                     fmt::format("line {}, column {}", std::ranges::count(before, '\n') + 1, offset - line_start + 1));
  }
}

replay::TechniqueRequest parse_technique(const JsonField& entry, std::size_t index, std::uint32_t samples) {
  check_names(entry, {"technique", "parameters"}, fmt::format("techniques[{}]", index));
  replay::TechniqueRequest request;
  request.technique = entry.member("technique").text();
  const replay::Technique& technique = replay::find_technique(printable(request.technique, 60));
  replay::ParameterValues given;
  if (entry.has("parameters")) {
    const JsonField parameters = entry.member("parameters");
    for (const auto& item : parameters.object().items()) {
      const JsonField value = parameters.member(item.key());
      if (!item.value().is_primitive() || item.value().is_null()) value.fail("expected a number, text or truth value");
      given[item.key()] = item.value();
    }
  }
  // The run's sample count is for the techniques that let one choose and were not given their own.
  for (const replay::Parameter& parameter : technique.parameters) {
    if (parameter.name == "samples" && parameter.allowed.size() != 1) given.try_emplace("samples", samples);
  }
  request.parameters = replay::check_parameters(technique.name, technique.parameters, given);
  return request;
}

std::vector<replay::TechniqueRequest> parse_techniques(const JsonField& list, std::uint32_t samples) {
  if (list.array_size() == 0) list.fail("expected at least one technique");
  if (list.array_size() > kMaxTechniques) list.fail(fmt::format("more than {} techniques", kMaxTechniques));
  std::vector<replay::TechniqueRequest> requests;
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    replay::TechniqueRequest request = parse_technique(list.element(i), i, samples);
    const bool twice = std::ranges::any_of(requests, [&](const replay::TechniqueRequest& other) {
      return other.technique == request.technique && other.parameters == request.parameters;
    });
    if (twice) list.element(i).fail("the same technique with the same parameters is asked for twice");
    requests.push_back(std::move(request));
  }
  return requests;
}

}  // namespace

RunRequest parse_run_request(std::string_view body) {
  const json document = parse_document(body);
  const JsonField top(document, std::string(kWhat));
  check_names(
      top,
      {"capture", "techniques", "samples", "frames", "width", "height", "repeat", "reference_samples", "point_lights"},
      "top level");
  RunRequest request;
  request.capture = top.member("capture").text();
  replay::ReplayOptions& options = request.options;
  options.samples = ranged(top, "samples", kSamples, options.samples);
  options.techniques = parse_techniques(top.member("techniques"), options.samples);
  options.width = ranged(top, "width", kSize, 0);
  options.height = ranged(top, "height", kSize, 0);
  if ((options.width == 0) != (options.height == 0)) {
    throw InputError(std::string(kWhat), "width and height are given together or not at all", "width, height");
  }
  options.repeat = ranged(top, "repeat", kRepeat, options.repeat);
  options.reference_samples = ranged(top, "reference_samples", kReferenceSamples, options.reference_samples);
  if (top.has("point_lights") && !top.member("point_lights").raw().is_null()) {
    options.point_lights = ranged(top, "point_lights", kPointLights, 0);
  }
  if (top.has("frames") && !top.member("frames").raw().is_null()) {
    const JsonField frames = top.member("frames");
    if (frames.array_size() != 2) frames.fail("expected [first, last]");
    options.frames = {frames.element(0).u32(), frames.element(1).u32()};
  }
  return request;
}

std::uint64_t resolve_frames(replay::ReplayOptions& options, std::uint32_t frame_count) {
  if (frame_count == 0) throw InputError(std::string(kWhat), "the capture has no frames", "capture");
  if (!options.frames) options.frames = {0, frame_count - 1};
  const auto [first, last] = *options.frames;
  if (first > last || last >= frame_count) {
    throw InputError(std::string(kWhat),
                     fmt::format("expected first <= last <= {}, got [{}, {}]", frame_count - 1, first, last), "frames");
  }
  const std::uint64_t results = (std::uint64_t{last} - first + 1) * options.techniques.size();
  if (results > kMaxResults) {
    throw InputError(std::string(kWhat), fmt::format("{} results; a run has at most {}", results, kMaxResults),
                     "frames, techniques");
  }
  return results;
}

replay::ReplayOptions thumbnail_options() {
  replay::ReplayOptions options;
  const replay::Technique& technique = replay::find_technique("noaa");
  options.techniques.push_back({"noaa", replay::check_parameters(technique.name, technique.parameters, {})});
  options.frames = {0, 0};
  options.width = 320;
  options.height = 180;
  options.repeat = 1;
  options.reference_samples = 0;
  return options;
}

}  // namespace subpixel::server
