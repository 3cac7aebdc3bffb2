#include "server/nightly/run_night.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/build_commit.hpp"
#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/hash.hpp"
#include "capture_format/writer.hpp"
#include "replay/measure/image_file.hpp"
#include "replay/measure/maps.hpp"
#include "replay/measure/metrics.hpp"
#include "server/nightly/against.hpp"
#include "server/nightly/gates.hpp"
#include "server/nightly/night_store.hpp"
#include "server/nightly/planned_capture.hpp"
#include "server/nightly/time_rounds.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::uint32_t kNightsBefore = 10;  // whose rounds are compared with besides the baseline's

// A frame whose capture is still replayed: until that is through nothing of it is stored.
struct Waiting {
  std::uint32_t ordinal;
  replay::FrameResult result;
  std::map<std::string, Blob> images;
};

class Night {
 public:
  Night(const NightlyConfig& config, const DataFolder& folder, Store& store, const NightOptions& options)
      : config_(config),
        folder_(folder),
        store_(store),
        nights_(store),
        options_(options),
        here_({options.worker, options.limits}, folder.night()),
        engine_(options.engine != nullptr ? *options.engine : here_) {}

  NightRecord run();

 private:
  void say(const std::string& line) const {
    if (options_.progress) options_.progress(line);
  }
  void plan();
  void plan_scene(const CaptureSource& source, PlannedCapture planned);
  void plan_tag(const CaptureSource& source, const PlannedCapture& planned);
  void add_planned(PlannedCapture planned);
  void replay_all();
  void store_capture(std::size_t index, ReplayEnd end, const std::vector<Waiting>& frames);
  ReplayRequest request_for(const PlannedCapture& planned) const;
  std::map<std::string, double> last_seconds(const std::string& capture) const;
  void judge_all();
  std::optional<ImageDifference> compare(NightFrame& tonight, const std::string& baseline);

  const NightlyConfig& config_;
  const DataFolder& folder_;
  Store& store_;
  NightStore nights_;
  const NightOptions& options_;
  LocalEngine here_;
  ReplayEngine& engine_;
  std::vector<PlannedCapture> planned_;
  std::optional<NightRecord> last_;  // the last night of the name, for what took how long
  NightRecord night_;
  std::optional<NightRecord> baseline_;
  EarlierRounds earlier_;
};

NightRecord Night::run() {
  nights_.interrupt_running();
  night_.name = config_.name;
  night_.build = SUBPIXEL_VERSION;
  night_.commit = options_.commit.empty() ? std::string(build_commit()) : options_.commit;
  night_.config = config_.document;
  night_.baseline = config_.baseline;
  night_.facts["folder"] = config_.folder.string();
  for (const BaselineRecord& baseline : nights_.baselines()) {
    if (baseline.name != config_.baseline) continue;
    night_.baseline_night = baseline.night;
    baseline_ = nights_.night(baseline.night, true);
  }
  if (baseline_) earlier_ = earlier_rounds(*baseline_, nights_.nights(kNightsBefore, 0, config_.name));
  for (NightRecord& night : nights_.nights(1, 0, config_.name)) last_ = std::move(night);
  night_.id = nights_.add(night_);
  plan();
  TimeRounds times(
      planned_, config_.gates, here_, [this](const PlannedCapture& planned) { return request_for(planned); },
      [this](const std::string& line) { say(line); });
  if (config_.gates.time) times.measure_noise(night_.facts);
  replay_all();
  compare_days(
      night_, planned_, options_.worker, options_.limits,
      [this](NightFrame& today, const std::string& yesterday) { return compare(today, yesterday); },
      [this](const std::string& line) { say(line); });
  judge_all();
  if (config_.gates.time) times.measure(night_, baseline_ ? &*baseline_ : nullptr, [this] { judge_all(); });
  nights_.set_facts(night_.id, night_.facts);
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
    PlannedCapture planned;
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

void Night::plan_scene(const CaptureSource& source, PlannedCapture planned) {
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

void Night::plan_tag(const CaptureSource& source, const PlannedCapture& planned) {
  std::vector<CaptureRecord> tagged = store_.captures_with_tag(source.tag);
  const auto add = [&](const CaptureRecord& record, const std::string& name) {
    PlannedCapture one = planned;
    one.capture.name = name;
    one.capture.source = "tag " + source.tag;
    one.capture.hash = record.hash;
    one.path = folder_.capture(record.hash);
    add_planned(std::move(one));
  };
  if (source.against_yesterday && !tagged.empty()) {
    std::ranges::sort(tagged, std::ranges::greater(), &CaptureRecord::uploaded_utc);
    night_.facts["against"][source.name] = json::object();
    add(tagged[0], source.name);
    if (tagged.size() > 1) {
      add(tagged[1], yesterday_name(source.name));
    } else {
      night_.facts["against"][source.name]["problem"] = "no earlier capture has the tag " + source.tag;
    }
    return;
  }
  for (const CaptureRecord& record : tagged) {
    const bool taken =
        std::ranges::any_of(planned_, [&](const PlannedCapture& other) { return other.capture.name == record.name; });
    add(record, taken ? record.name + " " + record.hash.substr(0, 8) : record.name);
  }
  if (!tagged.empty()) return;
  PlannedCapture none = planned;
  none.capture.source = "tag " + source.tag;
  none.capture.problem = "no stored capture has the tag " + source.tag;
  add_planned(std::move(none));
}

void Night::add_planned(PlannedCapture planned) {
  planned_.push_back(std::move(planned));
}

ReplayRequest Night::request_for(const PlannedCapture& planned) const {
  ReplayRequest request;
  request.name = planned.capture.name;
  request.capture_hash = planned.capture.hash;
  request.job = {planned.path, folder_.night() / "out", folder_.cache(), planned.options};
  const std::map<std::string, double> last = last_seconds(planned.capture.name);
  for (const replay::TechniqueRequest& technique : planned.options.techniques) {
    const auto found = last.find(technique_key(technique.technique, technique.parameters));
    if (found == last.end()) return request;  // one that is new: nothing is known of the whole
    request.technique_seconds.push_back(found->second);
  }
  return request;
}

// What each technique took of the last night's replay of a capture, warm and cold runs, measuring and all: the wall
// time that is no pass's is shared out evenly.
std::map<std::string, double> Night::last_seconds(const std::string& capture) const {
  std::map<std::string, double> seconds;
  if (!last_) return seconds;
  for (std::uint32_t i = 0; i < last_->captures.size(); ++i) {
    const NightCapture& measured = last_->captures[i];
    if (measured.name != capture || !measured.head) continue;
    double sum = 0;
    for (const NightCell& cell : last_->cells) {
      if (cell.capture == i) sum += seconds[cell.technique] = cell.time.own.ms * 1e-3 * measured.head->repeat;
    }
    const double rest =
        std::max(0.0, measured.head->wall_s - sum) / static_cast<double>(std::max<std::size_t>(seconds.size(), 1));
    for (auto& each : seconds) each.second += rest;
  }
  return seconds;
}

void Night::replay_all() {
  std::vector<ReplayRequest> requests;
  std::vector<std::size_t> indices;  // of the requests' captures
  for (std::size_t i = 0; i < planned_.size(); ++i) {
    if (!planned_[i].capture.problem.empty()) continue;
    requests.push_back(request_for(planned_[i]));
    indices.push_back(i);
  }
  std::vector<Waiting> waiting;  // results of the request that has not ended
  std::size_t next = 0;
  const auto store_without_replay = [&](std::size_t until) {
    for (; next < until; ++next) store_capture(next, {std::nullopt, planned_[next].capture.problem}, {});
  };
  ReplaySink sink;
  sink.progress = options_.progress;
  sink.result = [&](std::size_t, std::uint32_t ordinal, replay::FrameResult result,
                    std::map<std::string, Blob> images) {
    waiting.push_back({ordinal, std::move(result), std::move(images)});
  };
  sink.end = [&](std::size_t request, ReplayEnd end) {
    store_without_replay(indices[request]);
    store_capture(next++, std::move(end), std::exchange(waiting, {}));
  };
  engine_.replay(requests, sink);
  store_without_replay(planned_.size());
}

void Night::store_capture(std::size_t index, ReplayEnd end, const std::vector<Waiting>& frames) {
  const PlannedCapture& planned = planned_[index];
  NightCapture capture = planned.capture;
  capture.head = std::move(end.head);
  capture.problem = std::move(end.problem);
  if (!capture.problem.empty()) say(fmt::format("{}: {}", capture.name, capture.problem));
  std::vector<NightCell> cells;
  for (const replay::TechniqueRequest& request : planned.options.techniques) {
    NightCell cell;
    cell.capture = static_cast<std::uint32_t>(index);
    cell.technique = technique_key(request.technique, request.parameters);
    cells.push_back(std::move(cell));
  }
  nights_.add_capture(night_.id, static_cast<std::uint32_t>(index), capture);
  for (NightCell& cell : cells) cell.id = nights_.add_cell(night_.id, cell);
  for (const Waiting& frame : frames) {
    NightCell& cell = cells[frame.ordinal];
    cell.frames.push_back(nights_.add_frame(cell.id, frame.result, frame.images));
  }
  for (NightCell& cell : cells) cell.time = cell_time(cell, cells);
  night_.captures.push_back(std::move(capture));
  std::ranges::move(cells, std::back_inserter(night_.cells));
}

void Night::judge_all() {
  judge(
      night_, baseline_ ? &*baseline_ : nullptr, config_.gates,
      [this](NightFrame& tonight, const std::string& baseline) { return compare(tonight, baseline); }, earlier_);
  judge_against(night_, config_.gates);
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
    try {
      return Night(config, folder, store, options).run();
    } catch (const Error& error) {  // what the engine can't go on without
      NightStore(store).interrupt_running(error.what());
      throw;
    }
  } catch (const SqliteError& error) {
    throw InputError("can't store the night", error.disk_full() ? "the disk is full" : error.what(),
                     folder.store().string());
  }
}

}  // namespace subpixel::server
