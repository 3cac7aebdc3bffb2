#include "cli/capture_verbs.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/error.hpp"
#include "capture_format/generate/generate.hpp"
#include "capture_format/hash.hpp"
#include "capture_format/import/import.hpp"
#include "capture_format/json_text.hpp"
#include "capture_format/printable.hpp"
#include "capture_format/reader.hpp"
#include "capture_format/summary.hpp"
#include "capture_format/validator.hpp"
#include "capture_format/writer.hpp"

namespace subpixel::cli {
namespace {

struct Size {
  std::uint32_t width, height;
};

// "1280x720"; whether the sides are in range is for who uses them.
Size parse_size(const std::string& text) {
  const char* const end = text.data() + text.size();
  Size size{};
  auto [after_width, error] = std::from_chars(text.data(), end, size.width);
  if (error == std::errc() && after_width != end && *after_width == 'x') {
    const auto height = std::from_chars(after_width + 1, end, size.height);
    if (height.ec == std::errc() && height.ptr == end) return size;
  }
  throw UsageError("wrong size", "expected WIDTHxHEIGHT in pixels, got " + text, "--size");
}

void write_and_report(const capture::Capture& made, const std::string& path) {
  capture::write_capture(made, path);
  const nlohmann::json summary = capture::summarize(made, capture::content_hash_hex(std::filesystem::path(path)),
                                                    std::filesystem::file_size(path));
  fmt::print("{}: {} frames, {} draws, {} triangles, {:.1f} MB, hash {}\n", printable(path),
             summary["frame_count"].get<std::uint64_t>(), summary["draws"].get<std::uint64_t>(),
             summary["triangles"].get<std::uint64_t>(), summary["file_bytes"].get<double>() * 1e-6,
             summary["hash"].get<std::string>());
}

struct GenerateArguments {
  std::string scene, out, size;
  capture::GenerateOptions options;
  std::optional<std::uint32_t> frames;
  bool list = false;
};

void list_scenes() {
  constexpr std::array kTitles{"Scenes, 1280x720, 10 frames:", "Small scenes:",
                               "Hard cases, 32x24 to 64x48, 2 frames; with what every technique has to show:"};
  std::optional<capture::SceneGroup> group;
  for (const capture::SceneInfo& scene : capture::list_scenes()) {
    if (group != scene.group) fmt::print("{}{}\n", group ? "\n" : "", kTitles[static_cast<std::size_t>(scene.group)]);
    group = scene.group;
    fmt::print("  {:<22} {}\n", scene.name, scene.description);
    if (!scene.expectation.empty()) fmt::print("  {:<22} -> {}\n", "", scene.expectation);
  }
}

int generate(const GenerateArguments& arguments) {
  if (arguments.list) {
    list_scenes();
    return 0;
  }
  if (arguments.scene.empty() || arguments.out.empty()) {
    throw UsageError("can't generate", "a scene and a file to write are needed; --list names the scenes", "");
  }
  capture::GenerateOptions options = arguments.options;
  const capture::SceneInfo scene = capture::find_scene(arguments.scene);
  options.frames = arguments.frames.value_or(scene.frames);
  options.width = scene.width;
  options.height = scene.height;
  if (!arguments.size.empty()) {
    const Size size = parse_size(arguments.size);
    options.width = size.width;
    options.height = size.height;
  }
  write_and_report(capture::generate(arguments.scene, options), arguments.out);
  return 0;
}

void add_generate(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<GenerateArguments>();
  CLI::App* const verb = app.add_subcommand("generate", "Make the capture of a procedural scene");
  verb->add_option("scene", arguments->scene, "Scene; --list names them");
  verb->add_option("out", arguments->out, "Capture to write");
  verb->add_flag("--list", arguments->list, "List the scenes");
  verb->add_option("--frames", arguments->frames, "Frames, 1/30 s apart; default: 10, of hard cases 2");
  verb->add_option("--size", arguments->size, "WxH in pixels; default: 1280x720, of hard cases about 64x48");
  verb->add_option("--seed", arguments->options.seed, "The same seed gives the same bytes")->capture_default_str();
  verb->add_option("--density", arguments->options.density, "Factor on the number of blades, leaves, fibres, ...")
      ->capture_default_str();
  verb->callback([arguments, &action] { action = [arguments] { return generate(*arguments); }; });
}

struct ImportArguments {
  std::string in, out, camera, size;
  std::vector<std::string> assets;
  std::optional<std::uint32_t> frames;
};

int import(const ImportArguments& arguments) {
  capture::ImportOptions options;
  options.camera = arguments.camera;
  options.frames = arguments.frames;
  if (!arguments.size.empty()) {
    const Size size = parse_size(arguments.size);
    options.width = size.width;
    options.height = size.height;
  }
  options.asset_folders.assign(arguments.assets.begin(), arguments.assets.end());
  options.progress = [](const std::string& line) { fmt::print(stderr, "{}\n", printable(line)); };
  write_and_report(capture::import_file(arguments.in, options), arguments.out);
  return 0;
}

void add_import(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App* const verb = app.add_subcommand(
      "import", "Make a capture of a model file (glTF, GLB, OBJ, ...) or a scene description (.json)");
  verb->add_option("in", arguments->in, "Model or scene description")->required();
  verb->add_option("out", arguments->out, "Capture to write")->required();
  verb->add_option("--camera", arguments->camera, "Camera file, or 'orbit'; default: the file's own camera");
  verb->add_option("--frames", arguments->frames, "Frames; default: what the description says, else 10");
  verb->add_option("--size", arguments->size, "WxH in pixels; default: what the description says, else 1280x720");
  verb->add_option("--assets", arguments->assets, "Folder to look for archives and models in; may be repeated");
  verb->callback([arguments, &action] { action = [arguments] { return import(*arguments); }; });
}

struct FileArguments {
  std::string file;
  bool json = false;
};

int info(const FileArguments& arguments) {
  const std::filesystem::path path = arguments.file;
  const capture::Capture read = capture::read_capture(path);
  const nlohmann::json summary =
      capture::summarize(read, capture::content_hash_hex(path), std::filesystem::file_size(path));
  if (arguments.json) {
    fmt::print("{}\n", json_text(summary, 2));
    return 0;
  }
  for (const auto& [key, value] : summary.items()) {
    if (key == "frames") continue;  // one line each in the JSON form
    if (key == "notices") {
      for (const nlohmann::json& notice : value)
        fmt::print("{:<16} {}\n", "notice", printable(notice.get<std::string>()));
      continue;
    }
    std::string text = value.is_string() ? value.get<std::string>() : json_text(value);
    if (key == "features") {
      text.clear();
      for (const nlohmann::json& feature : value) text += (text.empty() ? "" : ", ") + feature.get<std::string>();
    }
    fmt::print("{:<16} {}\n", key, printable(text));
  }
  return 0;
}

int validate(const FileArguments& arguments) {
  const capture::Capture read = capture::read_capture(arguments.file);
  const std::vector<capture::Problem> problems = capture::validate_capture(read);
  std::size_t errors = 0;
  nlohmann::json list = nlohmann::json::array();
  for (const capture::Problem& problem : problems) {
    const bool is_error = problem.severity == capture::Problem::Severity::error;
    errors += is_error ? 1 : 0;
    const char* const severity = is_error ? "error" : "note";
    list.push_back({{"severity", severity}, {"why", problem.why}, {"where", problem.where}});
    if (!arguments.json) fmt::print("{}: {}: {}\n", severity, printable(problem.why), printable(problem.where));
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text({{"errors", errors}, {"problems", list}}, 2));
  } else {
    fmt::print("{}: {} errors, {} notes\n", printable(arguments.file), errors, problems.size() - errors);
  }
  return errors == 0 ? 0 : 1;
}

void add_file_verb(CLI::App& app, std::function<int()>& action, const char* name, const char* description,
                   int (*run)(const FileArguments&)) {
  const auto arguments = std::make_shared<FileArguments>();
  CLI::App* const verb = app.add_subcommand(name, description);
  verb->add_option("file", arguments->file, "Capture")->required();
  verb->add_flag("--json", arguments->json, "Print one JSON document");
  verb->callback([arguments, run, &action] { action = [arguments, run] { return run(*arguments); }; });
}

}  // namespace

void add_capture_verbs(CLI::App& app, std::function<int()>& action) {
  add_generate(app, action);
  add_import(app, action);
  add_file_verb(app, action, "info", "Say what a capture holds", &info);
  add_file_verb(app, action, "validate", "Look for mistakes in a capture; exit code 1 when there are errors",
                &validate);
}

}  // namespace subpixel::cli
