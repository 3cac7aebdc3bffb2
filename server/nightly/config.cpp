#include "server/nightly/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "replay/results/limits.hpp"
#include "replay/techniques/complete_technique.hpp"
#include "replay/techniques/registry.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

const std::string kWhat = "nightly configuration";

// A replay's limits are replay/results/limits.hpp's; these are of the night itself.
constexpr replay::Limit kKeepLimit{.name = "keep", .low = 0, .high = 1'000'000, .unit = "nights", .meaning = "kept"};
constexpr replay::Limit kTimeRoundsLimit{
    .name = "rounds", .low = 3, .high = 200, .unit = "rounds", .meaning = "a cell is measured at most, for its time"};
constexpr replay::Limit kQuietLimit{
    .name = "quiet_s", .low = 0, .high = 86'400, .unit = "seconds", .meaning = "since a watched file was written to"};
constexpr replay::Limit kAttemptsLimit{
    .name = "attempts", .low = 1, .high = 20, .unit = "times", .meaning = "a webhook is sent"};
constexpr std::size_t kMaxNameBytes = 100, kMaxAddressBytes = 2000, kMaxReceivers = 50;

constexpr std::string_view kMetrics[] = {"mse", "flip_mean", "flip_p99", "flip_max", "hdr_rel_mse", "flicker"};

// What holds for all captures and may be given for each.
struct Settings {
  std::vector<std::pair<std::string, std::string>> techniques;  // text and the field it stands in
  replay::ReplayOptions options;
};

std::string name_from(const JsonField& field) {
  std::string text = field.text();
  if (text.empty() || text.size() > kMaxNameBytes || printable(text, kMaxNameBytes) != text) {
    field.fail(fmt::format("expected a name of 1 to {} printable bytes", kMaxNameBytes));
  }
  return text;
}

double share(const JsonField& object, std::string_view name, double absent) {
  if (!object.has(name)) return absent;
  const JsonField field = object.member(name);
  const double value = field.number();
  if (!(value >= 0)) field.fail("expected a number of 0 or more");
  return value;
}

bool flag(const JsonField& object, std::string_view name, bool absent) {
  return object.has(name) ? object.member(name).truth() : absent;
}

Settings read_settings(const JsonField& object, const std::string& path, Settings settings) {
  replay::ReplayOptions& options = settings.options;
  options.samples = limited(object, replay::kSamplesLimit, options.samples);
  options.repeat = limited(object, replay::kRepeatLimit, options.repeat);
  options.reference_samples = limited(object, replay::kReferenceSamplesLimit, options.reference_samples);
  if (object.has("point_lights")) options.point_lights = limited(object, replay::kPointLightsLimit, 0);
  options.every_light = flag(object, "every_light", options.every_light);
  options.memory_mib = limited(object, replay::kMemoryLimit, options.memory_mib);
  if (object.has("size")) {
    const JsonField size = object.member("size");
    if (size.array_size() != 2) size.fail("expected [width, height]");
    const json sides = {{"width", size.element(0).raw()}, {"height", size.element(1).raw()}};
    const JsonField named(sides, kWhat, path + "size");
    options.width = limited(named, replay::kWidthLimit, 0);
    options.height = limited(named, replay::kHeightLimit, 0);
  }
  if (object.has("frames")) {
    const JsonField frames = object.member("frames");
    if (frames.array_size() != 2 || frames.element(0).u32() > frames.element(1).u32()) {
      frames.fail("expected [first, last]");
    }
    options.frames = {frames.element(0).u32(), frames.element(1).u32()};
  }
  if (object.has("techniques")) {
    settings.techniques.clear();
    const JsonField techniques = object.member("techniques");
    if (techniques.raw().is_string()) {
      settings.techniques.emplace_back(techniques.text(), path + "techniques");
    } else {
      for (std::size_t i = 0; i < techniques.array_size(); ++i) {
        settings.techniques.emplace_back(techniques.element(i).text(), fmt::format("{}techniques[{}]", path, i));
      }
    }
  }
  if (object.has("also")) settings.techniques.emplace_back(object.member("also").text(), path + "also");
  return settings;
}

// The whole registry with defaults, so that a technique that is added is replayed without a change of configuration.
std::vector<replay::TechniqueRequest> every_technique() {
  std::vector<replay::TechniqueRequest> requests;
  for (const replay::Technique* technique : replay::techniques()) {
    requests.push_back({std::string(technique->name), {}});
  }
  return requests;
}

std::vector<replay::TechniqueRequest> resolve_techniques(const Settings& settings, const std::string& where) {
  std::vector<replay::TechniqueRequest> requests;
  for (const auto& [text, field] : settings.techniques) {
    try {
      for (const replay::TechniqueRequest& given :
           text == "all" ? every_technique() : replay::parse_technique_list(text)) {
        if (!add_once(requests, replay::complete_technique(given, settings.options.samples)))
          throw InputError(kWhat, "asked for twice", given.technique);
      }
    } catch (const Error& error) {
      throw InputError(kWhat, error.what(), field);
    }
  }
  if (!replay::kTechniquesLimit.holds(requests.size())) {
    throw InputError(kWhat, replay::kTechniquesLimit.refusal(std::to_string(requests.size())), where + "techniques");
  }
  return requests;
}

CaptureSource read_capture(const JsonField& entry, std::size_t index, const Settings& common,
                           const std::filesystem::path& folder) {
  const std::string path = fmt::format("captures[{}].", index);
  check_names(entry,
              {"name", "path", "scene", "seed", "density", "tag", "against", "techniques", "also", "samples", "size",
               "frames", "repeat", "reference_samples", "point_lights", "every_light", "memory_mib"},
              kWhat, path.substr(0, path.size() - 1));
  const int kinds = (entry.has("path") ? 1 : 0) + (entry.has("scene") ? 1 : 0) + (entry.has("tag") ? 1 : 0);
  if (kinds != 1) entry.fail("expected one of path, scene and tag");
  const Settings settings = read_settings(entry, path, common);
  CaptureSource source;
  source.options = settings.options;
  source.options.techniques = resolve_techniques(settings, path);
  if (!entry.has("scene")) {
    for (const char* name : {"seed", "density"}) {
      if (entry.has(name)) entry.member(name).fail("is of a scene");
    }
  }
  if (entry.has("against")) {
    const JsonField against = entry.member("against");
    if (!entry.has("tag")) against.fail("is of a tag");
    if (against.text() != "yesterday") against.fail("expected \"yesterday\"");
    source.against_yesterday = true;
  }
  if (entry.has("path")) {
    source.kind = SourceKind::path;
    source.path = folder / entry.member("path").text();
    source.name = source.path.stem().string();
  } else if (entry.has("tag")) {
    source.kind = SourceKind::tag;
    source.name = source.tag = name_from(entry.member("tag"));
  } else {
    source.kind = SourceKind::scene;
    source.name = source.scene = entry.member("scene").text();
    if (entry.has("seed")) source.generate.seed = entry.member("seed").u64();
    source.generate.density = share(entry, "density", source.generate.density);
    if (!source.options.frames) source.options.frames = {0, 0};
    source.generate.frames = source.options.frames->second + 1;
    if (source.options.width > 0) source.generate.width = source.options.width;
    if (source.options.height > 0) source.generate.height = source.options.height;
  }
  if (entry.has("name")) source.name = name_from(entry.member("name"));
  return source;
}

// "hard_*" names every scene whose name begins so.
std::vector<std::string> scenes_named(const JsonField& field) {
  const std::string text = field.text();
  const bool prefix = text.ends_with('*');
  const std::string_view start = std::string_view(text).substr(0, text.size() - (prefix ? 1 : 0));
  std::vector<std::string> names;
  for (const capture::SceneInfo& scene : capture::list_scenes()) {
    if (prefix ? scene.name.starts_with(start) : scene.name == start) names.emplace_back(scene.name);
  }
  if (names.empty()) field.fail("there is no such scene; `subpixel generate --list` names them");
  return names;
}

// The sources of one entry: several for a scene's name with a star.
std::vector<CaptureSource> read_captures(const JsonField& entry, std::size_t index, const Settings& common,
                                         const std::filesystem::path& folder) {
  const CaptureSource source = read_capture(entry, index, common, folder);
  if (source.kind != SourceKind::scene) return {source};
  const std::vector<std::string> names = scenes_named(entry.member("scene"));
  if (names.size() == 1 && names[0] == source.scene) return {source};
  if (entry.has("name")) entry.member("name").fail("several scenes can't have one name");
  std::vector<CaptureSource> sources;
  for (const std::string& name : names) {
    sources.push_back(source);
    sources.back().name = sources.back().scene = name;
  }
  return sources;
}

ErrorBound read_bound(const JsonField& field, const std::string& path) {
  check_names(field, {"limit", "absolute", "relative"}, kWhat, path);
  ErrorBound bound;
  if (field.has("limit")) bound.limit = share(field, "limit", 0);
  bound.absolute = share(field, "absolute", 0);
  bound.relative = share(field, "relative", 0);
  return bound;
}

GateOptions read_gates(const JsonField& field) {
  check_names(field, {"memory", "shading", "counters", "images", "across", "against", "error", "time"}, kWhat, "gates");
  GateOptions gates;
  gates.memory = flag(field, "memory", true);
  gates.shading = flag(field, "shading", true);
  gates.counters = flag(field, "counters", true);
  gates.images = flag(field, "images", true);
  if (field.has("across")) {
    const JsonField across = field.member("across");
    check_names(across, {"relative", "absolute", "image_mse", "error"}, kWhat, "gates.across");
    gates.across_relative = share(across, "relative", gates.across_relative);
    gates.across_absolute = share(across, "absolute", gates.across_absolute);
    gates.across_error = share(across, "error", gates.across_error);
    gates.across_image_mse = share(across, "image_mse", gates.across_image_mse);
  }
  if (field.has("against")) {
    const JsonField against = field.member("against");
    check_names(against, {"draws", "triangles", "materials", "memory", "executions", "error"}, kWhat, "gates.against");
    for (auto& [name, allowed] : gates.against) allowed = share(against, name, allowed);
  }
  if (field.has("error")) {
    const JsonField error = field.member("error");
    for (const auto& item : error.object().items()) {
      const JsonField bound = error.member(item.key());
      if (std::ranges::find(kMetrics, item.key()) == std::end(kMetrics)) {
        throw InputError(
            kWhat, fmt::format("unknown metric {} (valid: {})", printable(item.key(), 60), fmt::join(kMetrics, ", ")),
            "gates.error");
      }
      gates.error[item.key()] = read_bound(bound, "gates.error." + item.key());
    }
  }
  if (field.has("time")) {
    const JsonField time = field.member("time");
    if (time.raw().is_boolean()) {
      gates.time = time.raw().get<bool>();
    } else {
      check_names(time, {"slower", "minimum_ms", "alarm", "rounds", "instructions"}, kWhat, "gates.time");
      gates.time_slower = share(time, "slower", gates.time_slower);
      gates.time_minimum_ms = share(time, "minimum_ms", gates.time_minimum_ms);
      gates.time_alarm = share(time, "alarm", gates.time_alarm);
      if (!(gates.time_alarm > 0 && gates.time_alarm <= 0.5))
        time.member("alarm").fail("expected more than 0, up to 0.5");
      gates.time_rounds = limited(time, kTimeRoundsLimit, gates.time_rounds);
      gates.instructions_more = share(time, "instructions", gates.instructions_more);
    }
  }
  return gates;
}

std::vector<WatchedFolder> read_watched(const JsonField& list, const std::filesystem::path& folder) {
  std::vector<WatchedFolder> watched;
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    const JsonField entry = list.element(i);
    check_names(entry, {"folder", "tag", "quiet_s"}, kWhat, fmt::format("watch[{}]", i));
    WatchedFolder one{folder / entry.member("folder").text(), name_from(entry.member("tag"))};
    one.quiet_s = limited(entry, kQuietLimit, one.quiet_s);
    watched.push_back(std::move(one));
  }
  return watched;
}

std::vector<TagLimit> read_tag_limits(const JsonField& tags) {
  std::vector<TagLimit> limits;
  for (const auto& item : tags.object().items()) {
    const JsonField entry = tags.member(item.key());
    check_names(entry, {"keep", "bytes"}, kWhat, "tags." + printable(item.key(), 60));
    TagLimit limit{item.key()};
    limit.keep = limited(entry, kKeepLimit, 0);
    if (entry.has("bytes")) limit.bytes = entry.member("bytes").u64();
    limits.push_back(std::move(limit));
  }
  return limits;
}

// What may stand in a mail's header and can't be an option of sendmail.
std::string mail_address(const JsonField& field) {
  std::string text = field.text();
  const std::size_t at = text.find('@');
  const bool plain = std::ranges::all_of(text, [](unsigned char c) {
    return c > 0x20 && c < 0x7f &&
           std::string_view(",;:<>()[]\\\"|&$`'").find(static_cast<char>(c)) == std::string_view::npos;
  });
  if (text.size() > 254 || text.starts_with('-') || at == 0 || at == std::string::npos || at + 1 == text.size() ||
      !plain)
    field.fail("expected an address like team@example.net");
  return text;
}

Webhook read_webhook(const JsonField& entry, std::size_t index) {
  check_names(entry, {"url", "secret_env"}, kWhat, fmt::format("notify.webhooks[{}]", index));
  const JsonField url = entry.member("url");
  Webhook hook{url.text(), ""};
  const bool scheme = hook.url.starts_with("http://") || hook.url.starts_with("https://");
  const std::size_t host = hook.url.find("://") + 3;
  const bool plain = std::ranges::all_of(hook.url, [](unsigned char c) { return c > 0x20 && c < 0x7f; });
  if (!scheme || !plain || hook.url.size() > kMaxAddressBytes || host >= hook.url.size() || hook.url[host] == '/' ||
      hook.url.find('@') != std::string::npos)
    url.fail("expected http://HOST/PATH or https://HOST/PATH, without a user's name");
  if (entry.has("secret_env")) {
    const JsonField name = entry.member("secret_env");
    hook.secret_variable = name.text();
    const bool word =
        std::ranges::all_of(hook.secret_variable, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
    if (hook.secret_variable.empty() || !word) name.fail("expected the name of a variable of the environment");
  }
  return hook;
}

NoticeOptions read_notices(const JsonField& field) {
  check_names(field, {"webhooks", "attempts", "mail", "only_failed"}, kWhat, "notify");
  NoticeOptions options;
  options.only_failed = flag(field, "only_failed", false);
  options.attempts = limited(field, kAttemptsLimit, options.attempts);
  if (field.has("webhooks")) {
    const JsonField hooks = field.member("webhooks");
    if (hooks.array_size() > kMaxReceivers) hooks.fail(fmt::format("more than {}", kMaxReceivers));
    for (std::size_t i = 0; i < hooks.array_size(); ++i) options.webhooks.push_back(read_webhook(hooks.element(i), i));
  }
  if (field.has("mail")) {
    const JsonField mail = field.member("mail");
    check_names(mail, {"to", "from", "sendmail"}, kWhat, "notify.mail");
    const JsonField to = mail.member("to");
    if (to.array_size() == 0 || to.array_size() > kMaxReceivers)
      to.fail(fmt::format("expected 1 to {}", kMaxReceivers));
    for (std::size_t i = 0; i < to.array_size(); ++i) options.mail_to.push_back(mail_address(to.element(i)));
    if (mail.has("from")) options.mail_from = mail_address(mail.member("from"));
    if (mail.has("sendmail")) options.sendmail = mail.member("sendmail").text();
    if (!options.sendmail.starts_with('/')) mail.member("sendmail").fail("expected an absolute path");
  }
  return options;
}

}  // namespace

GateOptions gates_of(const json& document) {
  try {
    if (document.contains("gates")) return read_gates(JsonField(document, kWhat).member("gates"));
  } catch (const Error&) {
    return {};  // of a version with other gates
  }
  return {};
}

NightlyConfig parse_nightly_config(std::string_view text, const std::filesystem::path& folder) {
  NightlyConfig config;
  config.folder = folder;
  config.document = parse_json_document(text, kWhat, "the file");
  const JsonField top(config.document, kWhat);
  check_names(
      top,
      {"name", "data", "baseline", "captures", "techniques", "samples", "size", "frames", "repeat", "reference_samples",
       "point_lights", "every_light", "memory_mib", "gates", "keep", "watch", "tags", "notify"},
      kWhat, "top level");
  config.name = name_from(top.member("name"));
  config.baseline = top.has("baseline") ? name_from(top.member("baseline")) : config.name;
  if (top.has("data")) config.data = folder / top.member("data").text();
  config.keep = limited(top, kKeepLimit, 0);
  const Settings common = read_settings(top, "", {});
  const JsonField captures = top.member("captures");
  if (captures.array_size() == 0) captures.fail("expected at least one capture");
  for (std::size_t i = 0; i < captures.array_size(); ++i) {
    for (CaptureSource& source : read_captures(captures.element(i), i, common, folder)) {
      const bool twice =
          std::ranges::any_of(config.captures, [&](const CaptureSource& other) { return other.name == source.name; });
      if (twice) captures.element(i).fail(fmt::format("another capture is named {}; give it a name", source.name));
      config.captures.push_back(std::move(source));
    }
  }
  if (top.has("watch")) config.watched = read_watched(top.member("watch"), folder);
  if (top.has("tags")) config.tag_limits = read_tag_limits(top.member("tags"));
  if (top.has("notify")) config.notices = read_notices(top.member("notify"));
  if (top.has("gates")) config.gates = read_gates(top.member("gates"));
  return config;
}

NightlyConfig read_nightly_config(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  if (!in || !std::filesystem::is_regular_file(file)) throw InputError(kWhat, "can't be read", file.string());
  text << in.rdbuf();
  try {
    return parse_nightly_config(text.str(), std::filesystem::absolute(file).parent_path());
  } catch (const Error& error) {
    throw InputError(file.string(), error.what(), "");
  }
}

}  // namespace subpixel::server
