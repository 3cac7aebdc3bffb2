#include "bench/report/store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/json_fields.hpp"
#include "capture_format/writer.hpp"
#include "replay/measure/comparison.hpp"
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

// Beside it, what its pairs of images differ by.
fs::path pairs_file_of(const RunPlan& run, const fs::path& folder) {
  return folder / (run.name() + ".pairs.json");
}

std::map<std::string, PairError> read_pairs(const RunPlan& run, const fs::path& folder) {
  const fs::path file = pairs_file_of(run, folder);
  std::map<std::string, PairError> pairs;
  if (run.pairs.empty() || !fs::exists(file)) return pairs;
  std::ifstream stream(file);
  const nlohmann::json stored = nlohmann::json::parse(stream, nullptr, false);
  const JsonField field(stored, file.string());
  for (const auto& item : field.object().items()) {
    const JsonField of = field.member(item.key());
    pairs[item.key()] = {of.member("mse").number(), of.member("flip_mean").number()};
  }
  return pairs;
}

bool is_stored(const RunPlan& run, const fs::path& folder) {
  const fs::path file = file_of(run, folder);
  if (!fs::exists(file) || !answers(replay::read_results(file), run)) return false;
  const auto pairs = read_pairs(run, folder);
  return std::ranges::all_of(run.pairs, [&](const ImagePair& pair) { return pairs.contains(pair_name(pair)); });
}

// The first frames of the scene, made when they are not there.
fs::path capture_of(const std::string& scene, std::uint32_t frames, const MeasureOptions& options) {
  const std::string several = frames > 1 ? fmt::format("_frames{}", frames) : "";
  fs::path file = options.folder / "captures" / (scene + several + ".spcap");
  if (fs::exists(file)) return file;
  fs::create_directories(file.parent_path());
  // Under its name only when it is whole.
  const fs::path part = options.folder / "captures" / "part.spcap";
  if (scene == "park") {
    capture::ImportOptions import;
    import.frames = frames;
    capture::write_capture(capture::import_file(options.source_root / "scenes/described/park.json", import),
                           part.string());
  } else {
    const auto at = scene.find('@');
    const std::string name = scene.substr(0, at);
    const capture::SceneInfo info = capture::find_scene(name);
    capture::GenerateOptions generate;
    if (at != std::string::npos) generate.density = std::stod(scene.substr(at + 1));
    generate.frames = frames;
    generate.width = info.width;
    generate.height = info.height;
    capture::write_capture(capture::generate(name, generate), part.string());
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
    fs::remove(pairs_file_of(run, folder));
  }
  fs::remove_all(folder / "captures");
}

// By the images that people look at.
void write_pairs(const RunPlan& run, const replay::Results& results, const fs::path& images, const fs::path& file) {
  nlohmann::json stored = nlohmann::json::object();
  const auto image_of = [&](const replay::TechniqueRequest& setting) {
    const auto found = std::ranges::find_if(results.results, [&](const replay::FrameResult& result) {
      return result.technique == setting.technique && result.parameters == setting.parameters;
    });
    if (found == results.results.end())
      throw std::logic_error("a pair of images is not in the run: " +
                             setting_name(setting.technique, setting.parameters));
    return replay::read_image_file(images / found->images.at("image"));
  };
  for (const ImagePair& pair : run.pairs) {
    const replay::Comparison of = replay::compare_images(image_of(pair.base), image_of(pair.test), {});
    stored[pair_name(pair)] = {{"mse", of.mse}, {"flip_mean", of.flip.mean}};
  }
  write_file_atomically(file, stored.dump(1));
}

void replay_run(const RunPlan& run, const fs::path& capture, const MeasureOptions& options, const std::string& label) {
  replay::ReplayJob job;
  job.capture = capture;
  job.out_dir = options.folder / "images";  // nobody looks at them
  job.cache_dir = options.folder / "references";
  job.options.techniques = run.techniques;
  job.options.frames = std::pair(0u, run.frames - 1);
  job.options.width = run.width;
  job.options.height = run.height;
  job.options.repeat = run.repeat;
  job.options.reference_samples = run.reference_samples;
  job.options.point_lights = run.point_lights;
  job.options.every_light = run.every_light;
  std::size_t done = 0;
  replay::ReplayEvents events;
  events.result = [&](std::uint32_t, const replay::FrameResult& result) {
    const std::string error = std::isnan(result.error.mse) ? "" : fmt::format(", MSE {:.2e}", result.error.mse);
    options.progress(fmt::format("{} {}/{} {}: {:.0f} ms{}", label, ++done, run.techniques.size() * run.frames,
                                 setting_name(result.technique, result.parameters), result.ms.total_ms, error));
  };
  const replay::Results results = replay::run_replay(job, events);
  if (!run.pairs.empty()) write_pairs(run, results, job.out_dir, pairs_file_of(run, options.folder));
  fs::remove_all(job.out_dir);
  replay::write_results(file_of(run, options.folder), results);
}

}  // namespace

bool is_timed(const RunPlan& run) {
  return run.repeat > 1;
}

bool answers(const replay::Results& results, const RunPlan& plan) {
  const replay::ResultsHead& head = results.head;
  if (head.width != plan.width || head.height != plan.height || head.repeat != plan.repeat ||
      head.reference_samples != plan.reference_samples ||
      // Only times depend on it.
      (is_timed(plan) && head.every_light != plan.every_light) ||
      results.results.size() != plan.techniques.size() * plan.frames)
    return false;
  if (plan.point_lights && head.point_lights != *plan.point_lights) return false;
  return std::ranges::all_of(plan.techniques, [&](const auto& request) {
    return std::ranges::count_if(results.results, [&](const auto& result) {
             return result.technique == request.technique && result.parameters == request.parameters;
           }) == plan.frames;
  });
}

void measure(const std::vector<RunPlan>& whole, const MeasureOptions& options) {
  fs::create_directories(options.folder);
  std::vector<RunPlan> plan;
  std::ranges::copy_if(whole, std::back_inserter(plan),
                       [&](const RunPlan& run) { return !options.timed || *options.timed == is_timed(run); });
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
      capture = capture_of(run.scene, run.frames, options);
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
    if (fs::exists(file)) measured.runs.push_back({run, replay::read_results(file), read_pairs(run, folder)});
  }
  return measured;
}

void publish(const std::vector<RunPlan>& plan, const fs::path& folder, const fs::path& to) {
  fs::create_directories(to);
  if (fs::equivalent(folder, to)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(to))
    if (entry.path().extension() == ".json") fs::remove(entry.path());
  for (const RunPlan& run : plan)
    for (const fs::path& file : {file_of(run, folder), pairs_file_of(run, folder)})
      if (fs::exists(file)) fs::copy_file(file, to / file.filename());
}

}  // namespace subpixel::report
