#include "server/nightly/run_night.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/hash.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "capture_format/writer.hpp"
#include "replay/measure/image_file.hpp"
#include "replay/measure/maps.hpp"
#include "replay/measure/metrics.hpp"
#include "server/nightly/gates.hpp"
#include "server/nightly/night_store.hpp"
#include "server/store/worker_files.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

// A capture of the night and how it is replayed.
struct Planned {
  NightCapture capture;
  std::filesystem::path path;
  replay::ReplayOptions options;
};

// What one worker process had to say.
struct Replayed {
  std::optional<replay::ResultsHead> head;
  std::string problem;  // why it is not complete; empty when it is
};

std::string last_line(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.remove_suffix(1);
  const std::size_t line = text.rfind('\n');
  return printable(line == std::string_view::npos ? text : text.substr(line + 1), 500);
}

// Replays `job` in a process of its own; `on_result` gets each result while its image files are there, with the place
// of its technique in the job's list.
Replayed replay_in_worker(const replay::ReplayJob& job, const std::filesystem::path& job_file,
                          const NightOptions& options,
                          const std::function<void(std::uint32_t, const replay::FrameResult&)>& on_result) {
  write_file_atomically(job_file, std::string_view(replay::to_json(job).dump()));
  Replayed replayed;
  std::string error;
  bool done = false;
  const auto take = [&](std::string_view line) {
    try {
      const json document = parse_json_document(line, "worker message", "the line");
      const JsonField message(document, "worker message");
      const std::string type = message.member("type").text();
      if (type == "head") replayed.head = replay::results_head_from_json(message.member("head").raw());
      if (type == "result") {
        const std::uint32_t ordinal = message.member("ordinal").u32();
        const replay::FrameResult result = replay::frame_result_from_json(message.member("result").raw());
        if (ordinal >= job.options.techniques.size() || job.options.techniques[ordinal].technique != result.technique)
          throw InputError("worker result", "it is not of this night", printable(result.technique, 60));
        on_result(ordinal, result);
      }
      if (type == "error") error = printable(message.member("message").text(), 1000);
      if (type == "done") done = true;
      return true;
    } catch (const json::exception& failure) {
      error = printable(failure.what(), 300);
    } catch (const Error& failure) {
      error = printable(failure.what(), 300);
    }
    return false;
  };
  std::filesystem::create_directories(job.out_dir);  // what is not there can't be allowed
  ChildLimits limits = options.limits;
  limits.confinement.emplace();
  limits.confinement->readable = {job.capture.string(), job_file.string()};
  limits.confinement->writable = {job.out_dir.string(), job.cache_dir.string()};
  limits.environment.push_back("MESA_SHADER_CACHE_DIR=" + (job.cache_dir / "mesa").string());
  const ChildOutcome outcome =
      run_child({options.worker.string(), "worker", "--job", job_file.string()}, limits, {}, take);
  if (!error.empty()) {
    replayed.problem = error;
  } else if (!outcome.reason.empty()) {
    replayed.problem = outcome.reason;
    const std::string words = last_line(outcome.error_tail);
    if (!words.empty()) replayed.problem += "; its last words: " + words;
  } else if (!done) {
    replayed.problem = "the worker process ended without saying that it was done";
  }
  return replayed;
}

class Night {
 public:
  Night(const NightlyConfig& config, const DataFolder& folder, Store& store, const NightOptions& options)
      : config_(config), folder_(folder), store_(store), nights_(store), options_(options) {}

  NightRecord run();

 private:
  void say(const std::string& line) const {
    if (options_.progress) options_.progress(line);
  }
  void plan();
  void plan_scene(const CaptureSource& source, Planned planned);
  void plan_tag(const CaptureSource& source, const Planned& planned);
  void add_planned(Planned planned);
  void replay_capture(std::size_t index);
  replay::ReplayJob job_for(const Planned& planned) const {
    return {planned.path, folder_.night() / "out", folder_.cache(), planned.options};
  }
  void judge_all();
  void confirm_times();
  bool measure_again(std::uint32_t capture, const std::vector<NightCell*>& slow);
  std::optional<ImageDifference> compare(NightFrame& tonight, const std::string& baseline);

  const NightlyConfig& config_;
  const DataFolder& folder_;
  Store& store_;
  NightStore nights_;
  const NightOptions& options_;
  std::vector<Planned> planned_;
  NightRecord night_;
  std::optional<NightRecord> baseline_;
};

NightRecord Night::run() {
  nights_.interrupt_running();
  night_.name = config_.name;
  night_.build = SUBPIXEL_VERSION;
  night_.config = config_.document;
  night_.baseline = config_.baseline;
  for (const BaselineRecord& baseline : nights_.baselines()) {
    if (baseline.name != config_.baseline) continue;
    night_.baseline_night = baseline.night;
    baseline_ = nights_.night(baseline.night, true);
  }
  night_.id = nights_.add(night_);
  plan();
  for (std::size_t i = 0; i < planned_.size(); ++i) replay_capture(i);
  judge_all();
  confirm_times();
  // What the baseline had besides comes into the store now.
  for (auto i = static_cast<std::uint32_t>(planned_.size()); i < night_.captures.size(); ++i) {
    nights_.add_capture(night_.id, i, night_.captures[i]);
  }
  for (NightCell& cell : night_.cells) {
    if (cell.id == 0) {
      cell.id = nights_.add_cell(night_.id, cell);
    } else {
      nights_.update_cell(cell);
    }
  }
  const CellCounts counts = count_cells(night_);
  nights_.finish(night_.id, counts.failed + counts.missing > 0 ? NightStatus::failed : NightStatus::passed, "");
  if (config_.keep > 0) nights_.drop_old(config_.name, config_.keep);
  return nights_.night(night_.id, true).value();
}

void Night::plan() {
  for (const CaptureSource& source : config_.captures) {
    Planned planned;
    planned.capture.name = source.name;
    planned.options = source.options;
    if (source.kind == SourceKind::scene) {
      plan_scene(source, std::move(planned));
    } else if (source.kind == SourceKind::tag) {
      plan_tag(source, planned);
    } else {
      planned.capture.source = source.path.string();
      planned.path = source.path;
      try {
        planned.capture.hash = content_hash_hex(source.path);
      } catch (...) {
        planned.capture.problem = failure_of(std::current_exception()).message;
      }
      add_planned(std::move(planned));
    }
  }
}

void Night::plan_scene(const CaptureSource& source, Planned planned) {
  planned.capture.source = fmt::format("scene {}, seed {}", source.scene, source.generate.seed);
  planned.path = folder_.night() / fmt::format("scene{}.spcap", planned_.size());
  try {
    capture::write_capture(capture::generate(source.scene, source.generate), planned.path);
    planned.capture.hash = content_hash_hex(planned.path);
  } catch (...) {
    planned.capture.problem = failure_of(std::current_exception()).message;
  }
  add_planned(std::move(planned));
}

void Night::plan_tag(const CaptureSource& source, const Planned& planned) {
  const std::vector<CaptureRecord> tagged = store_.captures_with_tag(source.tag);
  for (const CaptureRecord& record : tagged) {
    Planned one = planned;
    one.capture.name = record.name;
    one.capture.source = "tag " + source.tag;
    one.capture.hash = record.hash;
    one.path = folder_.capture(record.hash);
    const bool taken =
        std::ranges::any_of(planned_, [&](const Planned& other) { return other.capture.name == record.name; });
    if (taken) one.capture.name += " " + record.hash.substr(0, 8);
    add_planned(std::move(one));
  }
  if (!tagged.empty()) return;
  Planned none = planned;
  none.capture.source = "tag " + source.tag;
  none.capture.problem = "no stored capture has the tag " + source.tag;
  add_planned(std::move(none));
}

void Night::add_planned(Planned planned) {
  planned_.push_back(std::move(planned));
}

void Night::replay_capture(std::size_t index) {
  Planned& planned = planned_[index];
  NightCapture capture = planned.capture;
  std::vector<NightCell> cells;
  for (const replay::TechniqueRequest& request : planned.options.techniques) {
    NightCell cell;
    cell.capture = static_cast<std::uint32_t>(index);
    cell.technique = technique_key(request.technique, request.parameters);
    cells.push_back(std::move(cell));
  }
  // Until the worker is through nothing of the capture is stored; a cell's frames wait as results with their images.
  struct Waiting {
    std::size_t cell;
    replay::FrameResult result;
    std::map<std::string, Blob> images;
  };
  std::vector<Waiting> waiting;
  if (capture.problem.empty()) {
    say(fmt::format("{} ({}/{}): {} techniques", capture.name, index + 1, planned_.size(), cells.size()));
    const replay::ReplayJob job = job_for(planned);
    std::filesystem::create_directories(job.out_dir);
    const auto take = [&](std::uint32_t ordinal, const replay::FrameResult& result) {
      waiting.push_back({ordinal, result, read_worker_images(job.out_dir, result)});
    };
    Replayed replayed = replay_in_worker(job, folder_.night() / "job.json", options_, take);
    capture.head = replayed.head;
    capture.problem = replayed.problem;
    std::filesystem::remove_all(job.out_dir);
  }
  if (!capture.problem.empty()) say(fmt::format("{}: {}", capture.name, capture.problem));
  nights_.add_capture(night_.id, static_cast<std::uint32_t>(index), capture);
  for (NightCell& cell : cells) cell.id = nights_.add_cell(night_.id, cell);
  for (const Waiting& frame : waiting) {
    NightCell& cell = cells[frame.cell];
    cell.frames.push_back(nights_.add_frame(cell.id, frame.result, frame.images));
  }
  for (NightCell& cell : cells) cell.time = cell_time(cell, cells);
  night_.captures.push_back(std::move(capture));
  std::ranges::move(cells, std::back_inserter(night_.cells));
}

void Night::judge_all() {
  judge(night_, baseline_ ? &*baseline_ : nullptr, config_.gates,
        [this](NightFrame& tonight, const std::string& baseline) { return compare(tonight, baseline); });
}

// What else the machine does makes a technique slower now and then, but not twice in a row: the best of the ratios
// counts.
void Night::confirm_times() {
  const auto is_slow = [](const NightCell& cell) {
    return std::ranges::any_of(
        cell.gates, [](const GateResult& gate) { return gate.gate == "time" && gate.outcome == GateOutcome::failed; });
  };
  for (std::uint32_t turn = 0; turn < config_.gates.time_confirm; ++turn) {
    std::map<std::uint32_t, std::vector<NightCell*>> slow;
    for (NightCell& cell : night_.cells) {
      if (is_slow(cell)) slow[cell.capture].push_back(&cell);
    }
    if (slow.empty()) return;
    bool better = false;
    for (const auto& [capture, cells] : slow) better = measure_again(capture, cells) || better;
    if (better) judge_all();
  }
}

bool Night::measure_again(std::uint32_t capture, const std::vector<NightCell*>& slow) {
  Planned planned = planned_.at(capture);
  say(fmt::format("{}: {} slower than the baseline; measured again", planned.capture.name, slow.size()));
  std::set<std::string> wanted;
  for (const NightCell* cell : slow) {
    wanted.insert(cell->technique);
    for (const auto& reference : cell->time.references) wanted.insert(reference.first);
  }
  std::erase_if(planned.options.techniques, [&](const replay::TechniqueRequest& request) {
    return !wanted.contains(technique_key(request.technique, request.parameters));
  });
  planned.options.reference_samples = 0;
  std::vector<NightCell> cells;
  for (const replay::TechniqueRequest& request : planned.options.techniques)
    cells.emplace_back().technique = technique_key(request.technique, request.parameters);
  const replay::ReplayJob job = job_for(planned);
  std::filesystem::create_directories(job.out_dir);
  const auto take = [&](std::uint32_t ordinal, const replay::FrameResult& result) {
    cells[ordinal].frames.push_back({0, result, ""});
    for (const auto& image : result.images) {
      std::error_code ignored;
      std::filesystem::remove(job.out_dir / image.second, ignored);
    }
  };
  const Replayed replayed = replay_in_worker(job, folder_.night() / "job.json", options_, take);
  std::filesystem::remove_all(job.out_dir);
  if (!replayed.problem.empty()) return false;
  std::erase_if(cells, [](const NightCell& cell) { return cell.frames.empty(); });
  bool better = false;
  for (NightCell* cell : slow) {
    const auto again = std::ranges::find(cells, cell->technique, &NightCell::technique);
    if (again == cells.end()) continue;
    const CellTime time = cell_time(*again, cells);
    // The worst of the ratios, by which a cell is judged, since all have to be above.
    const auto least = [](const CellTime& measured) {
      double lowest = 1e300;
      for (const auto& reference : measured.references) {
        lowest = std::min(lowest, measured.own.ms / std::max(reference.second.ms, 1e-6));
      }
      return lowest;
    };
    if (time.references.empty() || least(time) >= least(cell->time)) continue;
    cell->time = time;
    better = true;
  }
  return better;
}

std::optional<ImageDifference> Night::compare(NightFrame& tonight, const std::string& baseline) {
  const std::optional<Blob> before = store_.blob(baseline);
  const std::optional<Blob> now = store_.blob(tonight.result.images.at("image"));
  if (!before || !now) return std::nullopt;
  try {
    const replay::Image a = replay::decode_png(before->bytes);
    const replay::Image b = replay::decode_png(now->bytes);
    const replay::Image map = replay::error_map(a, b);
    ImageDifference difference;
    difference.mse = replay::mse(a, b);
    for (const float value : map.pixels) {
      difference.largest = std::max(difference.largest, static_cast<double>(value));
      difference.pixels += value > 0 ? 1 : 0;
    }
    const std::vector<std::uint8_t> png = replay::encode_png(replay::colour_error(map));
    tonight.difference = nights_.add_difference(tonight.id, {"image/png", std::string(png.begin(), png.end())});
    return difference;
  } catch (const Error&) {
    return std::nullopt;  // another size, or no picture
  }
}

}  // namespace

NightRecord run_night(const NightlyConfig& config, const DataFolder& folder, Store& store,
                      const NightOptions& options) {
  try {
    return Night(config, folder, store, options).run();
  } catch (const SqliteError& error) {
    throw InputError("can't store the night", error.disk_full() ? "the disk is full" : error.what(),
                     folder.store().string());
  }
}

}  // namespace subpixel::server
