#include "cli/capture_verbs.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/base64.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "capture_format/reading/capture_file.hpp"
#include "capture_format/reading/reader.hpp"
#include "capture_format/reading/summary.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/tools/draw_table.hpp"
#include "capture_format/writer.hpp"
#include "cli/option_values.hpp"
#include "cli/written_summary.hpp"
#include "process/confinement.hpp"
#include "replay/frame_view.hpp"
#include "replay/results/parameters.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::cli {
namespace {

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
    const auto [width, height] = replay::parse_size(arguments.size, "--size");
    options.width = width;
    options.height = height;
  }
  const capture::Capture made = capture::generate(arguments.scene, options);
  capture::write_capture(made, arguments.out);
  fmt::print("{}: {}\n", printable(arguments.out), written_summary(made, arguments.out));
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

struct FileArguments {
  std::string file;
  bool json = false;
};

struct InfoArguments {
  FileArguments file;
  bool draws = false, seen = false;
  std::optional<std::uint32_t> frame;
  std::string size, device;
};

// Adds to the table of draws how the frame looks and which draw each pixel shows.
void add_view(nlohmann::json& table, const InfoArguments& options) {
  replay::FrameViewJob job{options.file.file, options.frame.value_or(0)};
  if (!options.size.empty()) std::tie(job.width, job.height) = replay::parse_size(options.size, "--size");
  const replay::FrameView view = replay::view_frame(job, options.device);
  std::vector<std::uint64_t> pixels(table["draws"].size(), 0);
  for (const std::uint32_t draw : view.draws)
    if (draw != replay::kNoDraw) ++pixels.at(draw);
  for (std::size_t d = 0; d < pixels.size(); ++d) table["draws"][d]["pixels"] = pixels[d];
  nlohmann::json runs = nlohmann::json::array();
  const std::vector<std::uint32_t> pairs = replay::runs_of(view.draws);
  for (std::size_t i = 0; i < pairs.size(); i += 2) {
    runs.push_back(pairs[i] == replay::kNoDraw ? nlohmann::json(-1) : nlohmann::json(pairs[i]));
    runs.push_back(pairs[i + 1]);
  }
  table["size"] = {view.picture.width, view.picture.height};
  table["device"] = view.device;
  table["picture"] = base64_text(replay::encode_png(view.picture));
  table["seen"] = std::move(runs);
}

void print_draws(const nlohmann::json& table) {
  const bool seen = table.contains("seen");
  fmt::print("frame {} {}\n{:>6} {:>10} {:>9} {:>10} {:>5} {:>12} {}draw; material; textures\n",
             table["frame"].get<std::uint32_t>(), printable(table["name"].get<std::string>(), 80), "number",
             "triangles", "instances", "vertices", "index", "bytes", seen ? "   pixels  " : " ");
  for (const nlohmann::json& draw : table["draws"]) {
    std::string textures;
    for (const nlohmann::json& texture : draw["textures"]) {
      const std::string slot = texture["slot"].get<std::string>();
      textures += (textures.empty() ? "" : ", ") + slot.substr(0, slot.rfind("_texture")) + " " +
                  texture["texture"].dump() + " " + printable(texture["name"].get<std::string>(), 40);
    }
    fmt::print("{:>6} {:>10} {:>9} {:>10} {:>5} {:>12} {} {}; {} {}; {}\n", draw["draw"].get<std::uint64_t>(),
               draw["triangles"].get<std::uint64_t>(), draw["instances"].get<std::uint64_t>(),
               draw["vertices"].get<std::uint64_t>(), draw["index_type"].get<std::string>(),
               draw["bytes"].get<std::uint64_t>(),
               seen ? fmt::format("{:>9} ", draw["pixels"].get<std::uint64_t>()) : "",
               printable(draw["name"].get<std::string>(), 60), draw["material"]["number"].dump(),
               printable(draw["material"]["name"].get<std::string>(), 40), textures.empty() ? "none" : textures);
  }
}

int info(const InfoArguments& options) {
  const FileArguments& arguments = options.file;
  forbid_programs();
  if (options.frame && !options.draws) throw UsageError("frames", "--frame is of --draws", "--frame");
  if (options.seen && !options.draws) throw UsageError("draws", "--seen is of --draws", "--seen");
  const std::filesystem::path path = arguments.file;
  const capture::CaptureFile::Outline outline = capture::CaptureFile(path).outline();
  nlohmann::json table;
  if (options.draws) {
    const std::size_t frames = outline.capture.frames.size();
    const std::uint32_t frame = options.frame.value_or(0);
    if (frames == 0) throw InputError(arguments.file, "it has no frames", "");
    if (frame >= frames) {
      throw UsageError("frames", fmt::format("{} is not within 0-{}", frame, frames - 1), "--frame");
    }
    table = capture::draw_table(outline.capture, frame);
    if (options.seen) add_view(table, options);
    if (!arguments.json) {
      print_draws(table);
      return 0;
    }
  }
  nlohmann::json summary = capture::summarize(outline.capture, outline.buffer_bytes, outline.texture_bytes,
                                              content_hash_hex(path), std::filesystem::file_size(path));
  if (arguments.json) {
    if (options.draws) summary["draws_of_frame"] = table;
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
    if (key == "feature_reasons") {
      for (const auto& [feature, why] : value.items())
        fmt::print("{:<16} {}: {}\n", "needs", feature, printable(why.get<std::string>()));
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

// A recording that broke off is not valid, and whoever asks wants to know what is left of it.
capture::Capture read_or_say_what_is_whole(const std::filesystem::path& path) {
  try {
    return capture::read_capture(path);
  } catch (const InputError& error) {
    std::size_t frames = 0;
    try {
      frames = capture::recover_capture(path).capture.frames.size();
    } catch (const InputError&) {
      throw error;
    }
    throw InputError(error.what(),
                     fmt::format("{} whole frames can be read; `subpixel repair FILE OUT` keeps them", frames), "");
  }
}

int validate(const FileArguments& arguments) {
  const capture::Capture read = read_or_say_what_is_whole(arguments.file);
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

struct RepairArguments {
  std::string file, out;
};

int repair(const RepairArguments& arguments) {
  const capture::Recovered recovered = capture::recover_capture(arguments.file);
  if (recovered.capture.frames.empty()) {
    throw InputError(arguments.file, "no frame of it is whole", recovered.stopped);
  }
  capture::write_capture(recovered.capture, arguments.out);
  fmt::print("{}: {}\n", printable(arguments.out), written_summary(recovered.capture, arguments.out));
  if (!recovered.stopped.empty()) fmt::print("what follows was lost: {}\n", printable(recovered.stopped));
  return 0;
}

void add_repair(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<RepairArguments>();
  CLI::App* const verb =
      app.add_subcommand("repair", "Write the whole frames of a capture whose recording broke off as a capture");
  verb->add_option("file", arguments->file, "What is left of the capture (.spcap or .spcap.part)")->required();
  verb->add_option("out", arguments->out, "Capture to write")->required();
  verb->callback([arguments, &action] { action = [arguments] { return repair(*arguments); }; });
}

void add_info(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* const verb = app.add_subcommand("info", "Say what a capture holds");
  verb->add_option("file", arguments->file.file, "Capture")->required();
  verb->add_flag("--json", arguments->file.json, "Print one JSON document");
  verb->add_flag("--draws", arguments->draws, "List a frame's draws in their order");
  verb->add_option("--frame", arguments->frame, "The frame of --draws; default: 0");
  verb->add_flag("--seen", arguments->seen,
                 "Of --draws: the frame's picture and the pixels that show each, by a device");
  verb->add_option("--size", arguments->size, "Of --seen: WIDTHxHEIGHT; as recorded when absent");
  verb->add_option("--device", arguments->device, "Of --seen: as of replay");
  verb->callback([arguments, &action] { action = [arguments] { return info(*arguments); }; });
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
  add_info(app, action);
  add_file_verb(app, action, "validate", "Look for mistakes in a capture; exit code 1 when there are errors",
                &validate);
  add_repair(app, action);
}

}  // namespace subpixel::cli
