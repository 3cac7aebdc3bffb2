#include "bench/report/store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "capture_format/writer.hpp"
#include "replay/replay.hpp"
#include "replay/results/results_file.hpp"
#include "scenes/generate/generate.hpp"
#include "scenes/import/import.hpp"

namespace subpixel::report {
namespace {

namespace fs = std::filesystem;

fs::path file_of(const RunPlan& run, const fs::path& folder) {
  return folder / (run.name() + ".json");
}

bool is_stored(const RunPlan& run, const fs::path& folder) {
  const fs::path file = file_of(run, folder);
  return fs::exists(file) && answers(replay::read_results(file), run);
}

// The first frame of the scene, made when it is not there.
fs::path capture_of(const std::string& scene, const MeasureOptions& options) {
  const fs::path file = options.folder / "captures" / (scene + ".spcap");
  if (fs::exists(file)) return file;
  fs::create_directories(file.parent_path());
  // Under its name only when it is whole.
  const fs::path part = options.folder / "captures" / "part.spcap";
  if (scene == "park") {
    capture::ImportOptions import;
    import.frames = 1;
    capture::write_capture(capture::import_file(options.source_root / "scenes/described/park.json", import),
                           part.string());
  } else {
    const capture::SceneInfo info = capture::find_scene(scene);
    capture::GenerateOptions generate;
    generate.frames = 1;
    generate.width = info.width;
    generate.height = info.height;
    capture::write_capture(capture::generate(scene, generate), part.string());
  }
  fs::rename(part, file);
  return file;
}

void put_aside(const std::vector<RunPlan>& plan, const fs::path& folder) {
  for (const RunPlan& run : plan) {
    const fs::path file = file_of(run, folder);
    if (!fs::exists(file)) continue;
    fs::create_directories(folder / "previous");
    fs::rename(file, folder / "previous" / file.filename());
  }
  fs::remove_all(folder / "captures");
}

void replay_run(const RunPlan& run, const fs::path& capture, const MeasureOptions& options, const std::string& label) {
  replay::ReplayJob job;
  job.capture = capture;
  job.out_dir = options.folder / "images";  // nobody looks at them
  job.cache_dir = options.folder / "references";
  job.options.techniques = run.techniques;
  job.options.frames = std::pair(0u, 0u);
  job.options.width = run.width;
  job.options.height = run.height;
  job.options.repeat = run.repeat;
  job.options.reference_samples = run.reference_samples;
  job.options.point_lights = run.point_lights;
  std::size_t done = 0;
  replay::ReplayEvents events;
  events.result = [&](std::uint32_t, const replay::FrameResult& result) {
    const std::string error = std::isnan(result.error.mse) ? "" : fmt::format(", MSE {:.2e}", result.error.mse);
    options.progress(fmt::format("{} {}/{} {}: {:.0f} ms{}", label, ++done, run.techniques.size(),
                                 setting_name(result.technique, result.parameters), result.ms.total_ms, error));
  };
  const replay::Results results = replay::run_replay(job, events);
  fs::remove_all(job.out_dir);
  replay::write_results(file_of(run, options.folder), results);
}

}  // namespace

bool answers(const replay::Results& results, const RunPlan& plan) {
  const replay::ResultsHead& head = results.head;
  if (head.width != plan.width || head.height != plan.height || head.repeat != plan.repeat ||
      head.reference_samples != plan.reference_samples || results.results.size() != plan.techniques.size())
    return false;
  if (plan.point_lights && head.point_lights != *plan.point_lights) return false;
  return std::ranges::equal(results.results, plan.techniques, [](const auto& result, const auto& request) {
    return result.technique == request.technique && result.parameters == request.parameters;
  });
}

void measure(const std::vector<RunPlan>& plan, const MeasureOptions& options) {
  fs::create_directories(options.folder);
  const auto stored = [&](const RunPlan& run) { return is_stored(run, options.folder); };
  if (options.fresh || std::ranges::all_of(plan, stored)) {
    put_aside(plan, options.folder);
  } else if (const auto kept = std::ranges::count_if(plan, stored); kept > 0) {
    options.progress(fmt::format("{} of {} runs are stored already; the others follow", kept, plan.size()));
  }
  const auto start = std::chrono::steady_clock::now();
  std::set<std::string> missing;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const RunPlan& run = plan[i];
    if (missing.contains(run.scene) || stored(run)) continue;
    const double minutes = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / 60;
    const std::string label = fmt::format("[{}/{}] {}", i + 1, plan.size(), run.name());
    options.progress(fmt::format("{}: after {:.1f} min", label, minutes));
    fs::path capture;
    try {
      capture = capture_of(run.scene, options);
    } catch (const InputError& error) {
      if (run.scene != "park") throw;
      options.progress(fmt::format("{} is left out: {}", run.scene, error.what()));
      missing.insert(run.scene);
      continue;
    }
    replay_run(run, capture, options, label);
  }
}

Measured read_measured(const std::vector<RunPlan>& plan, const fs::path& folder) {
  Measured measured;
  for (const RunPlan& run : plan) {
    const fs::path file = file_of(run, folder);
    if (fs::exists(file)) measured.runs.push_back({run, replay::read_results(file)});
  }
  return measured;
}

}  // namespace subpixel::report
