#include "cli/replay_verbs.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/hash.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "cli/engine_options.hpp"
#include "cli/option_values.hpp"
#include "cli/progress_line.hpp"
#include "process/confinement.hpp"
#include "replay/gpu/device.hpp"
#include "replay/replay.hpp"
#include "replay/results/plots.hpp"
#include "replay/results/results_file.hpp"
#include "replay/techniques/complete_technique.hpp"
#include "replay/techniques/registry.hpp"
#include "server/engine/shard_folder.hpp"

namespace subpixel::cli {
namespace {

using namespace subpixel::replay;

struct ReplayFlags {
  std::string file, techniques, frames, size, json_file, out = "out", cache, capture_frame, device;
  bool validate = false;
  std::uint32_t samples = 8, repeat = 3, reference_samples = 512;
  std::optional<std::uint32_t> point_lights;
  bool every_light = false;
  std::string memory;
  std::shared_ptr<EngineFlags> engine;
};

// plot_COST_ERROR.svg for each cost and error, and the points behind them.
void write_plots(const std::filesystem::path& folder, const Results& results) {
  const std::vector<Summary> summaries = summarise(results);
  if (results.head.reference_samples > 0) {
    for (std::size_t cost = 0; cost < std::size(kPlotCosts); ++cost) {
      for (std::size_t error = 0; error < std::size(kPlotErrors); ++error) {
        const Plot plot = make_plot(summaries, static_cast<PlotCost>(cost), static_cast<PlotError>(error));
        if (plot.points.empty()) continue;
        write_file_atomically(folder / fmt::format("plot_{}_{}.svg", kPlotCosts[cost], kPlotErrors[error]),
                              std::string_view(to_svg(plot)));
      }
    }
  }
  write_file_atomically(folder / "points.csv", std::string_view(points_csv(summaries)));
  write_file_atomically(folder / "points.md", std::string_view(points_markdown(summaries)));
}

[[noreturn]] void fail(const server::ReplayEnd& end) {
  if (end.exit_code == kUsageExit) throw UsageError("replay", end.problem, "");
  if (end.exit_code == kInputExit) throw InputError("replay", end.problem, "");
  if (end.exit_code == kInternalExit) throw InternalError("replay", end.problem, "");
  throw DeviceError("replay", end.problem, "");
}

// The same as run_replay() by another engine: its files come into out_dir, under the names that they would have there.
Results replay_elsewhere(const ReplayJob& job, server::ReplayEngine& engine) {
  server::ReplayRequest request;
  request.name = job.capture.stem().string();
  request.capture_hash = content_hash_hex(job.capture);
  request.job = job;
  // A mistake in the request is told here, before anything waits in a queue.
  for (const TechniqueRequest& technique : job.options.techniques) complete_technique(technique, job.options.samples);
  Results results;
  server::ReplaySink sink;
  sink.progress = [](const std::string& line) { fmt::print(stderr, "{}\n", printable(line)); };
  sink.result = [&](std::size_t, std::uint32_t, FrameResult result, const std::map<std::string, server::Blob>& images) {
    for (const auto& [role, file] : result.images) {
      write_file_atomically(job.out_dir / file, std::string_view(images.at(role).bytes));
    }
    results.results.push_back(std::move(result));
  };
  sink.end = [&](std::size_t, const server::ReplayEnd& end) {
    if (!end.problem.empty()) fail(end);
    if (end.head) results.head = *end.head;
  };
  engine.replay({request}, sink);
  return results;
}

void replay_and_write(const ReplayFlags& flags, const ReplayInspection& inspection) {
  ReplayJob job;
  job.capture = flags.file;
  job.out_dir = flags.out;
  job.cache_dir = flags.cache.empty() ? job.out_dir / "cache" : std::filesystem::path(flags.cache);
  job.options.techniques = parse_technique_list(flags.techniques);
  job.options.samples = flags.samples;
  if (!flags.frames.empty()) job.options.frames = parse_frames(flags.frames);
  if (!flags.size.empty()) std::tie(job.options.width, job.options.height) = replay::parse_size(flags.size, "--size");
  job.options.repeat = flags.repeat;
  job.options.reference_samples = flags.reference_samples;
  job.options.point_lights = flags.point_lights;
  job.options.every_light = flags.every_light;
  if (!flags.memory.empty()) job.options.memory_mib = replay::parse_memory(flags.memory, "--memory");

  Results results;
  const std::unique_ptr<server::ReplayEngine> engine =
      make_engine(*flags.engine, {std::filesystem::read_symlink("/proc/self/exe"), {}}, job.out_dir, job.cache_dir);
  if (engine) {
    if (inspection.validation_messages != nullptr || inspection.capture || !inspection.device.empty()) {
      throw UsageError("command line", "it is of --engine local", "--validate, --capture-frame, --device");
    }
    results = replay_elsewhere(job, *engine);
  } else {
    ProgressLine line;
    ReplayEvents events;
    events.progress = [&](const std::string& stage, std::uint32_t done, std::uint32_t total,
                          const std::string& detail) { line.update(stage, done, total, detail); };
    results = run_replay(job, events, inspection);
  }
  const std::filesystem::path json =
      flags.json_file.empty() ? job.out_dir / "results.json" : std::filesystem::path(flags.json_file);
  if (json == "-") {
    std::cout << json_text(to_json(results), 2) << "\n";
    return;
  }
  write_results(json, results);
  write_plots(job.out_dir, results);
  std::cout << to_table(results);
  fmt::print("images, maps, plots: {}   results: {}\n", printable(job.out_dir.string()), printable(json.string()));
}

// Prints what the validation layer said; returns how many errors are among it.
std::size_t print_validation(const std::vector<std::string>& messages) {
  std::size_t errors = 0;
  for (const std::string& message : messages) {
    fmt::print(stderr, "validation: {}\n", printable(message));
    errors += message.starts_with("error: ") ? 1 : 0;
  }
  return errors;
}

int replay(const ReplayFlags& flags) {
  ReplayInspection inspection;
  inspection.device = flags.device;
  std::vector<std::string> messages;
  if (flags.validate) inspection.validation_messages = &messages;
  if (!flags.capture_frame.empty()) {
    const auto [frame, technique] = parse_frame_of_technique(flags.capture_frame);
    inspection.capture = {frame, technique};
  }
  try {
    replay_and_write(flags, inspection);
  } catch (...) {
    print_validation(messages);  // the likely reason first
    throw;
  }
  const std::size_t errors = print_validation(messages);
  // Our calls, so our mistakes.
  if (errors > 0) throw std::logic_error(fmt::format("the Vulkan validation layer found {} errors", errors));
  return 0;
}

void print_line(const nlohmann::json& message) {
  std::cout << json_text(message) << std::endl;  // flushed: the reader acts on whole lines
}

int worker(const std::string& job_file) {
  try {
    std::ifstream in(job_file, std::ios::binary);
    if (!in) throw InputError("worker job", "can't be read", job_file);
    std::stringstream text;
    text << in.rdbuf();
    nlohmann::json json;
    try {
      json = nlohmann::json::parse(text.str());
    } catch (const nlohmann::json::parse_error& error) {
      throw InputError("worker job", error.what(), job_file);
    }
    const ReplayJob job = replay_job_from_json(json);
    std::filesystem::create_directories(job.out_dir);
    forbid_programs();
    ReplayEvents events;
    events.progress = [](const std::string& stage, std::uint32_t done, std::uint32_t total, const std::string& detail) {
      print_line({{"type", "progress"}, {"stage", stage}, {"done", done}, {"total", total}, {"detail", detail}});
    };
    events.head = [](const ResultsHead& head) { print_line({{"type", "head"}, {"head", to_json(head)}}); };
    events.result = [](std::uint32_t ordinal, const FrameResult& result) {
      print_line({{"type", "result"}, {"ordinal", ordinal}, {"result", to_json(result)}});
    };
    run_replay(job, events);
  } catch (...) {
    const Failure end = failure_of(std::current_exception());
    print_line({{"type", "error"}, {"message", end.message}, {"exit", int{end.exit_code}}});
    return end.exit_code;
  }
  print_line({{"type", "done"}});
  return 0;
}

std::string parameter_range(const Parameter& p) {
  if (!p.choices.empty()) return fmt::format("{}", fmt::join(p.choices, " | "));
  if (!p.allowed.empty()) return fmt::format("{}", fmt::join(p.allowed, " | "));
  if (p.kind == ParameterKind::boolean) return "true | false";
  return fmt::format("{} to {}", p.minimum, p.maximum);
}

int list_techniques(bool json) {
  if (json) {
    std::cout << json_text(registry_json(), 2) << "\n";
    return 0;
  }
  for (const Technique* technique : techniques()) {
    fmt::print("{}: {}\n", technique->name, technique->title);
    if (!technique->paper.empty()) fmt::print("  {}\n", technique->paper);
    for (const Parameter& p : technique->parameters) {
      const std::string value =
          p.default_value.is_string() ? p.default_value.get<std::string>() : p.default_value.dump();
      fmt::print("  {:16} {}{}{}; default {}\n  {:16} {}\n", p.name, parameter_range(p), p.unit.empty() ? "" : " ",
                 p.unit, value, "", p.doc);
    }
  }
  return 0;
}

int list_devices() {
  const std::vector<gpu::VulkanDevice> devices = gpu::vulkan_devices();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const gpu::VulkanDevice& device = devices[i];
    std::string state = !device.missing.empty() ? fmt::format("lacks {}", fmt::join(device.missing, ", "))
                        : device.is_lavapipe    ? "taken by default"
                                                : "has what all passes need";
    if (!device.missing_in_part.empty())
      state += fmt::format("; without {}, for which some passes have another way and others refuse it",
                           fmt::join(device.missing_in_part, ", "));
    fmt::print("{} {}: {}\n", i, printable(device.name), state);
  }
  return 0;
}

}  // namespace

void add_replay_verbs(CLI::App& app, std::function<int()>& action) {
  CLI::App* list = app.add_subcommand("techniques", "List the techniques with their parameters");
  const auto json = std::make_shared<bool>(false);
  list->add_flag("--json", *json, "Print the registry as one JSON document");
  list->callback([&action, json] { action = [json] { return list_techniques(*json); }; });

  app.add_subcommand("devices", "List the Vulkan devices, and what each lacks")->callback([&action] {
    action = &list_devices;
  });

  CLI::App* run = app.add_subcommand("replay", "Replay a capture through techniques and measure them");
  const auto flags = std::make_shared<ReplayFlags>();
  run->add_option("file", flags->file, "The capture (.spcap)")->required();
  run->add_option("--techniques", flags->techniques, "a,b:param=v,...; see `subpixel techniques`")->required();
  run->add_option("--samples", flags->samples, "Samples per pixel of techniques that don't name theirs")
      ->transform(within(kSamplesLimit))
      ->capture_default_str();
  run->add_option("--frames", flags->frames, "FIRST-LAST, from 0; all when absent");
  run->add_option("--size", flags->size, "WIDTHxHEIGHT; as recorded when absent");
  run->add_option("--repeat", flags->repeat, "Timed runs of every frame; medians are reported")
      ->transform(within(kRepeatLimit))
      ->capture_default_str();
  run->add_option("--reference-samples", flags->reference_samples, "Visibility samples of the reference; 0: none")
      ->transform(within(kReferenceSamplesLimit))
      ->capture_default_str();
  run->add_option("--lights", flags->point_lights, "Point lights: this many; as recorded when absent")
      ->transform(within(kPointLightsLimit));
  run->add_flag(
      "--every-light", flags->every_light,
      "Every shading point evaluates all point lights, not only those whose range may hold it: the same bits, "
      "and times as of renderers that do so");
  run->add_option("--memory", flags->memory,
                  "What a frame's passes may hold at a time, as 512M or 2G: beyond it the frame is drawn in bands, the "
                  "same bits; no limit when absent");
  run->add_option("--out", flags->out, "Folder for images, maps and results.json")->capture_default_str();
  run->add_option("--json", flags->json_file,
                  "Results file (default OUT/results.json); - prints it instead of the table");
  run->add_option("--cache", flags->cache, "Folder of cached references (default OUT/cache)");
  run->add_option("--device", flags->device,
                  "Number, or part of the name, of a device that `subpixel devices` lists; lavapipe when absent");
  run->add_flag(
      "--validate", flags->validate,
      "Run under the Vulkan validation layer (Debian: vulkan-validationlayers), slowly; its errors end with 70");
  run->add_option("--capture-frame", flags->capture_frame,
                  "FRAME:TECHNIQUE that RenderDoc, under which this has to run, captures into OUT");
  flags->engine = add_engine_options(*run);
  run->callback([&action, flags] { action = [flags] { return replay(*flags); }; });

  CLI::App* work = app.add_subcommand("worker", "Run one job of the service; its messages go to standard output");
  const auto job = std::make_shared<std::string>();
  work->add_option("--job", *job, "The job, JSON")->required();
  work->callback([&action, job] { action = [job] { return worker(*job); }; });

  CLI::App* shard = app.add_subcommand("shard", "Do one task of a night that is divided among nodes");
  const auto task = std::make_shared<std::string>();
  shard->add_option("--task", *task, "The task, JSON, beside the folders it names")->required();
  shard->callback([&action, task] {
    action = [task] {
      server::run_shard_task(*task);
      return 0;
    };
  });
}

}  // namespace subpixel::cli
