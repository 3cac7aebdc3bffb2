#include "cli/import_verbs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/import_process.hpp"
#include "cli/option_values.hpp"
#include "scenes/import/import.hpp"

namespace subpixel::cli {
namespace {

constexpr std::uint64_t kMebibyte = 1u << 20;
constexpr std::uint32_t kModelSeconds = 300, kFrameSeconds = 3600;

struct ImportArguments {
  std::string in, out, camera, size;
  std::vector<std::string> assets;
  RenderDocOptions renderdoc;
  std::string events, target, textures, sun;
  std::optional<std::uint32_t> frames;
  std::optional<std::uint64_t> limit_memory;  // MiB
  std::optional<std::uint32_t> limit_seconds;
};

// Of the exporter of RenderDoc captures, those that are given.
std::vector<std::pair<const char*, const std::string*>> renderdoc_values(const ImportArguments& arguments) {
  std::vector<std::pair<const char*, const std::string*>> given;
  for (const auto& [name, value] : {std::pair{"--events", &arguments.events},
                                    {"--target", &arguments.target},
                                    {"--textures", &arguments.textures},
                                    {"--sun", &arguments.sun}}) {
    if (!value->empty()) given.emplace_back(name, value);
  }
  return given;
}

int import(const ImportArguments& arguments) {
  if (!arguments.size.empty()) replay::parse_size(arguments.size, "--size");
  std::vector<std::string> options;
  const auto add = [&](const char* name, const std::string& value) {
    options.push_back(fmt::format("{}={}", name, value));
  };
  if (!arguments.camera.empty()) add("--camera", arguments.camera);
  if (!arguments.size.empty()) add("--size", arguments.size);
  if (arguments.frames) add("--frames", std::to_string(*arguments.frames));
  for (const std::string& folder : arguments.assets) add("--assets", folder);
  for (const std::string& next : arguments.renderdoc.more) add("--next", next);
  if (arguments.renderdoc.on_display) options.emplace_back("--on-display");
  for (const auto& [name, value] : renderdoc_values(arguments)) add(name, *value);
  ImportLimits limits;
  // RenderDoc replays the frame up to each draw that is asked about.
  const bool is_frame = is_renderdoc(arguments.in);
  limits.duration = std::chrono::seconds(arguments.limit_seconds.value_or(is_frame ? kFrameSeconds : kModelSeconds));
  limits.is_confined = !(is_frame && arguments.renderdoc.on_display);
  limits.address_space_bytes =
      arguments.limit_memory ? *arguments.limit_memory * kMebibyte : default_import_address_space();
  import_in_child(arguments.in, arguments.out, options, limits);
  return 0;
}

int work(const ImportArguments& arguments) {
  capture::ImportOptions options;
  options.camera = arguments.camera;
  options.frames = arguments.frames;
  if (!arguments.size.empty()) {
    const auto [width, height] = replay::parse_size(arguments.size, "--size");
    options.width = width;
    options.height = height;
  }
  options.asset_folders.assign(arguments.assets.begin(), arguments.assets.end());
  RenderDocOptions renderdoc = arguments.renderdoc;
  for (const auto& [name, value] : renderdoc_values(arguments)) {
    renderdoc.arguments.push_back(fmt::format("{}={}", name, *value));
  }
  return import_worker(arguments.in, arguments.out, std::move(options), renderdoc);
}

void add_common(CLI::App& verb, ImportArguments& arguments) {
  verb.add_option("in", arguments.in, "Model, scene description or RenderDoc capture")->required();
  verb.add_option("out", arguments.out, "Capture to write")->required();
  verb.add_option("--camera", arguments.camera, "Camera file, or 'orbit'; default: the file's own camera");
  verb.add_option("--frames", arguments.frames, "Frames; default: what the description says, else 10");
  verb.add_option("--size", arguments.size, "WxH in pixels; default: what the description says, else 1280x720");
  verb.add_option("--assets", arguments.assets, "Folder to look for archives and models in; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--next", arguments.renderdoc.more, "RenderDoc: capture of the next frame; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--events", arguments.events, "RenderDoc: FIRST-LAST, only draws of these event ids")
      ->check([](const std::string& text) {
        return std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || c == '-'; })
                   ? std::string()
                   : "not FIRST-LAST";
      });
  verb.add_option("--target", arguments.target,
                  "RenderDoc: id of the main view's depth target; default: most triangles");
  verb.add_option("--textures", arguments.textures, "RenderDoc: JSON file of texture names and slots for each role");
  verb.add_flag("--on-display", arguments.renderdoc.on_display,
                "RenderDoc: replay on the display and by the drivers found here, not confined; default: on the CPU");
  verb.add_option("--sun", arguments.sun, "RenderDoc: X,Y,Z, the way a sun's light travels; default: no sun");
}

}  // namespace

void add_import_verbs(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App* const verb = app.add_subcommand(
      "import",
      "Make a capture of a model file (glTF, GLB, OBJ, ...), a scene description (.json) or RenderDoc captures (.rdc)");
  add_common(*verb, *arguments);
  verb->add_option("--limit-memory", arguments->limit_memory,
                   "MiB of address space for reading; 0: no limit; default: three quarters of the machine's memory, at "
                   "most 8192")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40));
  verb->add_option("--limit-seconds", arguments->limit_seconds,
                   "Longest time for reading; 0: no limit; default: 300, of RenderDoc captures 3600");
  verb->callback([arguments, &action] { action = [arguments] { return import(*arguments); }; });

  const auto worker_arguments = std::make_shared<ImportArguments>();
  CLI::App* const worker = app.add_subcommand("import-worker", "What import runs; messages go to standard output");
  worker->group("");  // not in the help
  add_common(*worker, *worker_arguments);
  worker->callback([worker_arguments, &action] { action = [worker_arguments] { return work(*worker_arguments); }; });
}

}  // namespace subpixel::cli
