#include "server/nightly/run_night.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
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
#include "server/nightly/time_test.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

// A capture of the night and how it is replayed.
struct Planned {
  NightCapture capture;
  std::filesystem::path path;
  replay::ReplayOptions options;
};

constexpr std::uint32_t kNoiseRounds = 9, kFirstRounds = 8;
// Rounds of one worker process: where a process has its memory is part of the noise, so there are several.
constexpr std::uint32_t kRoundsOfProcess = 4;
constexpr std::uint32_t kNightsBefore = 10;  // whose rounds are compared with besides the baseline's
constexpr double kLeastShare = 0.02;         // a smaller share of slowness is not worth rounds without end

// What a round measures. Where the device is the processor, the time of all its threads: a busy machine makes them
// wait, which this does not count, and what it does count is the work.
enum class Measure { device_time, processor_time };

Measure measure_of(const replay::ResultsHead& head) {
  return head.device.starts_with("llvmpipe") ? Measure::processor_time : Measure::device_time;
}

double span_of_least(const NightCell& cell, Measure measure) {
  double ms = 0;
  for (const NightFrame& frame : cell.frames) {
    ms += measure == Measure::processor_time ? frame.result.ms.processor_ms : frame.result.ms.least_ms;
  }
  return ms;
}

// `round` as `cell` sees it, unless it lacks the cell or one of its references.
void add_round(NightCell& cell, const std::vector<NightCell>& round, Measure measure) {
  const auto ms_of = [&](const std::string& technique) {
    const auto found = std::ranges::find(round, technique, &NightCell::technique);
    return found == round.end() || found->frames.size() != cell.frames.size() ? 0.0 : span_of_least(*found, measure);
  };
  TimeRound one{ms_of(cell.technique), {}};
  for (const auto& reference : cell.time.references) {
    one.references[reference.first] = ms_of(reference.first);
    if (!(one.references[reference.first] > 0)) return;
  }
  if (one.own > 0) cell.time.rounds.push_back(std::move(one));
}

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
  void plan_scene(const CaptureSource& source, Planned planned);
  void plan_tag(const CaptureSource& source, const Planned& planned);
  void compare_days();
  void compare_frames(NightCell& today, const NightCell& yesterday);
  void add_planned(Planned planned);
  void replay_all();
  void store_capture(std::size_t index, ReplayEnd end, const std::vector<Waiting>& frames);
  ReplayRequest request_for(const Planned& planned) const;
  std::map<std::string, double> last_seconds(const std::string& capture) const;
  void judge_all();
  void measure_noise();
  void measure_times();
  void add_rounds(const std::map<std::uint32_t, std::vector<NightCell*>>& wanted, std::uint32_t rounds);
  // Rounds of times of a capture by some of its techniques; each one cells with frames, in the techniques' order.
  std::vector<std::vector<NightCell>> time_capture(std::uint32_t capture, const std::set<std::string>& techniques,
                                                   std::uint32_t rounds);
  // Worth more rounds: above what is allowed by the medians.
  bool looks_slower(const NightCell& cell) const;
  std::optional<ImageDifference> compare(NightFrame& tonight, const std::string& baseline);

  const NightlyConfig& config_;
  const DataFolder& folder_;
  Store& store_;
  NightStore nights_;
  const NightOptions& options_;
  LocalEngine here_;
  ReplayEngine& engine_;
  std::vector<Planned> planned_;
  std::optional<NightRecord> last_;  // the last night of the name, for what took how long
  NightRecord night_;
  std::optional<NightRecord> baseline_;
  EarlierRounds earlier_;
  std::uint32_t rounds_ = kRoundsOfProcess;  // of every cell
  Measure measure_ = Measure::device_time;
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
  if (config_.gates.time) measure_noise();
  replay_all();
  compare_days();
  judge_all();
  measure_times();
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
  std::vector<CaptureRecord> tagged = store_.captures_with_tag(source.tag);
  const auto add = [&](const CaptureRecord& record, const std::string& name) {
    Planned one = planned;
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
        std::ranges::any_of(planned_, [&](const Planned& other) { return other.capture.name == record.name; });
    add(record, taken ? record.name + " " + record.hash.substr(0, 8) : record.name);
  }
  if (!tagged.empty()) return;
  Planned none = planned;
  none.capture.source = "tag " + source.tag;
  none.capture.problem = "no stored capture has the tag " + source.tag;
  add_planned(std::move(none));
}

// Today's draws against yesterday's, and their pictures.
void Night::compare_days() {
  if (!night_.facts.contains("against")) return;
  for (auto& [name, summary] : night_.facts["against"].items()) {
    if (summary.contains("problem")) continue;
    const auto of_name = [&](const std::string& wanted) {
      return std::ranges::find(planned_, wanted, [](const Planned& planned) { return planned.capture.name; });
    };
    const auto today = of_name(name), yesterday = of_name(yesterday_name(name));
    say(fmt::format("{}: today's draws against yesterday's", name));
    try {
      summary = against_summary(difference_in_worker(yesterday->path, today->path, options_.worker, options_.limits),
                                yesterday->capture.hash, today->capture.hash);
    } catch (const Error& error) {
      summary["problem"] = error.what();
      continue;
    }
    for (NightCell& cell : night_.cells) {
      if (night_.captures.at(cell.capture).name != name) continue;
      for (const NightCell& other : night_.cells) {
        if (other.technique != cell.technique || night_.captures.at(other.capture).name != yesterday_name(name))
          continue;
        compare_frames(cell, other);
      }
    }
  }
}

void Night::compare_frames(NightCell& today, const NightCell& yesterday) {
  for (NightFrame& frame : today.frames) {
    const auto then = std::ranges::find(yesterday.frames, frame.result.frame,
                                        [](const NightFrame& other) { return other.result.frame; });
    if (then == yesterday.frames.end()) continue;
    const auto before = then->result.images.find("image");
    const auto now = frame.result.images.find("image");
    if (before == then->result.images.end() || now == frame.result.images.end() || before->second == now->second)
      continue;
    compare(frame, before->second);
  }
}

void Night::add_planned(Planned planned) {
  planned_.push_back(std::move(planned));
}

ReplayRequest Night::request_for(const Planned& planned) const {
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
  const Planned& planned = planned_[index];
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

void Night::measure_noise() {
  for (std::size_t i = 0; i < planned_.size(); ++i) {
    if (!planned_[i].capture.problem.empty()) continue;
    std::set<std::string> references;
    for (const replay::TechniqueRequest& request : planned_[i].options.techniques) {
      const std::string key = technique_key(request.technique, request.parameters);
      if (request.technique == "noaa" || (request.technique == "msaa" && references.size() < 2)) references.insert(key);
    }
    if (references.size() < 2) continue;
    say(fmt::format("the machine's noise: {} rounds of {}", kNoiseRounds, planned_[i].capture.name));
    std::vector<double> logs;
    for (const std::vector<NightCell>& round : time_capture(static_cast<std::uint32_t>(i), references, kNoiseRounds)) {
      const double a = span_of_least(round[0], measure_), b = span_of_least(round[1], measure_);
      if (a > 0 && b > 0) logs.push_back(std::log(a / b));
    }
    const double noise = ratio_noise(logs);
    double load = 0;
    ::getloadavg(&load, 1);
    night_.facts["noise"] = noise;
    night_.facts["load"] = load;
    rounds_ = rounds_for(noise, std::max(config_.gates.time_slower, kLeastShare), config_.gates.time_rounds);
    return;
  }
}

std::vector<std::vector<NightCell>> Night::time_capture(std::uint32_t capture, const std::set<std::string>& techniques,
                                                        std::uint32_t rounds) {
  Planned planned = planned_.at(capture);
  std::erase_if(planned.options.techniques, [&](const replay::TechniqueRequest& request) {
    return !techniques.contains(technique_key(request.technique, request.parameters));
  });
  planned.options.reference_samples = 0;
  planned.options.rounds = rounds;
  std::vector<NightCell> none;
  for (const replay::TechniqueRequest& request : planned.options.techniques)
    none.emplace_back().technique = technique_key(request.technique, request.parameters);
  std::vector<std::vector<NightCell>> measured(rounds, none);
  // A frame's rounds come one after the other, then those of the next frame.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> seen;
  std::string problem;
  ReplaySink sink;
  sink.result = [&](std::size_t, std::uint32_t ordinal, replay::FrameResult result,
                    const std::map<std::string, Blob>&) {
    const std::uint32_t round = seen[{result.frame, ordinal}]++;
    if (round < rounds) measured[round][ordinal].frames.push_back({0, std::move(result), ""});
  };
  sink.end = [&](std::size_t, const ReplayEnd& end) {
    problem = end.problem;
    if (end.head) measure_ = measure_of(*end.head);
  };
  // Here and on no other node: times of one night are compared with those of others.
  here_.replay({request_for(planned)}, sink);
  if (!problem.empty()) {
    say(fmt::format("{}: times: {}", planned.capture.name, problem));
    return {};
  }
  return measured;
}

void Night::add_rounds(const std::map<std::uint32_t, std::vector<NightCell*>>& wanted, std::uint32_t rounds) {
  for (const auto& [capture, cells] : wanted) {
    std::set<std::string> techniques;
    for (const NightCell* cell : cells) {
      techniques.insert(cell->technique);
      for (const auto& reference : cell->time.references) techniques.insert(reference.first);
    }
    for (const std::vector<NightCell>& round : time_capture(capture, techniques, rounds)) {
      for (NightCell* cell : cells) add_round(*cell, round, measure_);
    }
  }
}

// What else the machine does comes and goes, so the rounds of a capture are spread over all of the night. Every cell
// gets as many as the noise asks for, those that look slower and the first of a baseline as many as there may be.
void Night::measure_times() {
  const GateOptions& gates = config_.gates;
  if (!gates.time) return;
  std::map<std::uint32_t, std::vector<NightCell*>> timed;
  for (NightCell& cell : night_.cells) {
    if (cell.id == 0 || cell.frames.empty() || cell.time.references.empty() ||
        cell.time.own.ms < gates.time_minimum_ms || cell.capture >= planned_.size() ||
        !night_.captures[cell.capture].problem.empty())
      continue;
    timed[cell.capture].push_back(&cell);
  }
  if (timed.empty()) return;
  // What may become a baseline is compared with often.
  const std::uint32_t all = baseline_ ? rounds_ : std::min(gates.time_rounds, std::max(kFirstRounds, 2 * rounds_));
  const auto measure = [&](const auto& cells, std::uint32_t rounds) {
    for (std::uint32_t done = 0; done < rounds; done += kRoundsOfProcess) {
      say(fmt::format("times: {} of {} rounds, {} captures", done, rounds, cells.size()));
      add_rounds(cells, std::min(kRoundsOfProcess, rounds - done));
    }
  };
  measure(timed, all);
  night_.facts["rounds"] = all;
  night_.facts["measure"] = measure_ == Measure::processor_time ? "processor time" : "device time";
  judge_all();
  if (!baseline_ || all >= gates.time_rounds) return;
  std::map<std::uint32_t, std::vector<NightCell*>> open;
  std::size_t count = 0;
  for (auto& [capture, cells] : timed) {
    for (NightCell* cell : cells) {
      if (!looks_slower(*cell)) continue;
      open[capture].push_back(cell);
      ++count;
    }
  }
  if (open.empty()) return;
  say(fmt::format("{} cells look slower and are measured again", count));
  night_.facts["measured_again"] = count;
  measure(open, gates.time_rounds - all);
  judge_all();
}

bool Night::looks_slower(const NightCell& cell) const {
  const NightCell* before = nullptr;
  for (const NightCell& other : baseline_->cells) {
    if (other.technique == cell.technique &&
        baseline_->captures.at(other.capture).name == night_.captures.at(cell.capture).name)
      before = &other;
  }
  if (before == nullptr) return false;
  const TimeVerdict verdict = test_times(cell.time.rounds, before->time.rounds, {config_.gates.time_slower, 0});
  return !verdict.detail.empty() && verdict.decision != TimeDecision::not_slower;
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
