#include "server/nightly/gates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/nightly/against.hpp"
#include "server/nightly/time_test.hpp"

namespace subpixel::server {
namespace {

using replay::FrameResult;

// Collects what differs over the frames of a cell; the first of it is told, the rest counted.
class Differences {
 public:
  void add(std::uint32_t frame, const std::string& text) {
    if (count_++ == 0) first_ = fmt::format("frame {}: {}", frame, text);
  }
  bool any() const { return count_ > 0; }
  std::string text() const { return count_ > 1 ? fmt::format("{} (and {} more)", first_, count_ - 1) : first_; }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

struct FramePair {
  NightFrame* tonight;
  const NightFrame* baseline;
};

struct Tolerance {
  double share = 0, absolute = 0;
};

// Equal, or within a share of the baseline and an absolute rest.
bool agrees(double tonight, double baseline, const Tolerance& tolerance) {
  return tonight == baseline ||
         std::abs(tonight - baseline) <= tolerance.share * std::abs(baseline) + tolerance.absolute;
}

std::vector<std::pair<std::string, double>> memory_values(const FrameResult& result) {
  const replay::Memory& memory = result.memory;
  return {{"paper bytes per pixel", memory.paper_bytes_per_pixel},
          {"fitted bytes per pixel", memory.fitted_bytes_per_pixel},
          {"paper bytes", static_cast<double>(memory.paper_bytes)},
          {"fitted bytes", static_cast<double>(memory.fitted_bytes)},
          {"allocated bytes", static_cast<double>(memory.allocated_bytes)}};
}

std::vector<std::pair<std::string, double>> error_values(const FrameResult& result) {
  const replay::ImageError& error = result.error;
  return {{"mse", error.mse},           {"flip_mean", error.flip_mean},     {"flip_p99", error.flip_p99},
          {"flip_max", error.flip_max}, {"hdr_rel_mse", error.hdr_rel_mse}, {"flicker", error.flicker}};
}

double error_value(const FrameResult& result, const std::string& metric) {
  for (const auto& [name, value] : error_values(result)) {
    if (name == metric) return value;
  }
  return std::nan("");
}

// "llvmpipe (LLVM 15.0.6, 256 bits)" without the width of vectors, which changes no bit (docs/nightly.md).
std::string device_class(std::string device) {
  const std::size_t comma = device.rfind(", ");
  if (device.starts_with("llvmpipe") && device.ends_with(" bits)") && comma != std::string::npos)
    device.replace(comma, std::string::npos, ")");
  return device;
}

// Whose processors approximate alike; of others each model is a class of its own.
std::string processor_class(const std::string& model) {
  for (const char* const vendor : {"AMD", "Intel"}) {
    if (model.find(vendor) != std::string::npos) return vendor;
  }
  return model;
}

// Replays are equal bit for bit.
bool same_class(const replay::ResultsHead& a, const replay::ResultsHead& b) {
  return a.driver == b.driver && a.driver_version == b.driver_version &&
         device_class(a.device) == device_class(b.device) &&
         processor_class(a.cpu_model) == processor_class(b.cpu_model);
}

// And take as long.
bool same_machine(const replay::ResultsHead& a, const replay::ResultsHead& b) {
  return a.driver == b.driver && a.driver_version == b.driver_version && a.device == b.device &&
         a.cpu_model == b.cpu_model;
}

// One cell against its counterpart.
class CellJudge {
 public:
  CellJudge(NightCell& cell, const GateOptions& options) : cell_(cell), options_(options) {}

  void add(const std::string& gate, GateOutcome outcome, const std::string& detail) {
    cell_.gates.push_back({gate, outcome, detail});
  }
  void add(const std::string& gate, const Differences& differences, const std::string& when_passed) {
    add(gate, differences.any() ? GateOutcome::failed : GateOutcome::passed,
        differences.any() ? differences.text() : when_passed);
  }

  void judge_alone(const std::string& problem) {
    if (cell_.frames.empty() || !problem.empty()) {
      add("replay", GateOutcome::failed, problem.empty() ? "it was not replayed" : problem);
      if (cell_.frames.empty()) return;
    }
    Differences invalid;
    for (const NightFrame& frame : cell_.frames) {
      for (const auto& [counter, whose] :
           {std::pair{"invalid_pixels", ""}, {"invalid_reference_pixels", "reference: "}}) {
        const auto found = frame.result.counters.find(counter);
        if (found == frame.result.counters.end() || found->second == 0) continue;
        invalid.add(frame.result.frame, fmt::format("{}{} pixels are NaN, infinite or negative", whose, found->second));
      }
    }
    add("valid", invalid, "every pixel is a finite number of 0 or more");
  }

  // `slack`: a share of the baseline on top of the bounds.
  void judge_error(const std::vector<FramePair>& pairs, double slack = 0) {
    for (const auto& [metric, bound] : options_.error) {
      Differences differences;
      for (const NightFrame& frame : cell_.frames) {
        const double value = error_value(frame.result, metric);
        if (bound.limit && !(value <= *bound.limit) && !std::isnan(value)) {
          differences.add(frame.result.frame, fmt::format("{:.4g} is above the limit of {:.4g}", value, *bound.limit));
        }
      }
      for (const FramePair& pair : pairs) {
        const double before = error_value(pair.baseline->result, metric);
        const double now = error_value(pair.tonight->result, metric);
        if (std::isnan(before)) continue;
        const double allowed = before * (1 + bound.relative + slack) + bound.absolute;
        if (!(now <= allowed)) {
          differences.add(
              pair.tonight->result.frame,
              fmt::format("{:.6g}, the baseline has {:.6g}; up to {:.6g} is allowed", now, before, allowed));
        }
      }
      add("error " + metric, differences, pairs.empty() ? "within its limit" : "no worse than the baseline");
    }
  }

  void judge_exact(const std::vector<FramePair>& pairs, bool same, const CompareImages& compare) {
    const Tolerance counted = same ? Tolerance{} : Tolerance{options_.across_relative, options_.across_absolute};
    const Tolerance bytes = same ? Tolerance{} : Tolerance{options_.across_relative, 0};
    const std::string passed = same ? "equal" : fmt::format("within {:g}%", 100 * options_.across_relative);
    if (options_.memory) add("memory", compare_values(pairs, bytes, memory_values), passed);
    if (options_.shading) {
      add("shading",
          compare_values(pairs, counted,
                         [](const FrameResult& result) {
                           return std::vector<std::pair<std::string, double>>{
                               {"lighting executions", static_cast<double>(result.shading.executions)}};
                         }),
          passed);
    }
    if (options_.counters) {
      // A counter that the baseline does not have is news, not a failure.
      add("counters",
          compare_values(pairs, counted,
                         [](const FrameResult& result) {
                           std::vector<std::pair<std::string, double>> values;
                           for (const auto& [name, value] : result.counters) {
                             values.emplace_back(name, static_cast<double>(value));
                           }
                           return values;
                         }),
          passed);
    }
    if (options_.images) {
      add("images", compare_images(pairs, same, compare), same ? "equal" : "alike");
      if (same) add("metrics", compare_metrics(pairs), "equal where the images are");
    }
  }

  // `before`: rounds of the baseline and of the nights since. `alarm`: the false-alarm rate of one cell.
  void judge_time(const std::vector<TimeRound>& before, bool same, double alarm) {
    if (!options_.time) return;
    if (!same) return add("time", GateOutcome::skipped, "times of another machine say nothing");
    if (cell_.time.references.empty()) {
      return add("time", GateOutcome::skipped, "there is no msaa or noaa of the same run to compare it with");
    }
    if (cell_.time.own.ms < options_.time_minimum_ms) {
      return add("time", GateOutcome::skipped,
                 fmt::format("{:.1f} ms is too short to judge ({:g} ms)", cell_.time.own.ms, options_.time_minimum_ms));
    }
    const TimeVerdict verdict = test_times(cell_.time.rounds, before, {options_.time_slower, alarm});
    if (verdict.detail.empty()) {
      return add("time", GateOutcome::skipped, "no round of tonight and of before has the same techniques");
    }
    if (verdict.decision == TimeDecision::undecided && least_p(cell_.time.rounds.size(), before.size()) > alarm) {
      return add("time", GateOutcome::skipped, "too few rounds to tell: " + verdict.detail);
    }
    add("time", verdict.decision == TimeDecision::slower ? GateOutcome::failed : GateOutcome::passed, verdict.detail);
  }

  void judge_instructions(const CellTime& before, bool same) {
    if (!options_.time || !same || !(before.instructions > 0) || !(cell_.time.instructions > 0)) return;
    const double more = cell_.time.instructions / before.instructions - 1;
    add("instructions", more > options_.instructions_more ? GateOutcome::failed : GateOutcome::passed,
        fmt::format("{:.4g}, the baseline {:.4g} ({:+.2f}%; up to {:+.2f}% is allowed)", cell_.time.instructions,
                    before.instructions, 100 * more, 100 * options_.instructions_more));
  }

  void conclude(bool has_baseline) {
    const bool failed =
        std::ranges::any_of(cell_.gates, [](const GateResult& gate) { return gate.outcome == GateOutcome::failed; });
    cell_.status = failed ? CellStatus::failed : has_baseline ? CellStatus::passed : CellStatus::new_;
  }

 private:
  template <class ValuesOf>
  static Differences compare_values(const std::vector<FramePair>& pairs, const Tolerance& tolerance,
                                    ValuesOf values_of) {
    Differences differences;
    for (const FramePair& pair : pairs) {
      const auto now = values_of(pair.tonight->result);
      for (const auto& [name, before] : values_of(pair.baseline->result)) {
        const auto found = std::ranges::find(now, name, [](const auto& value) { return value.first; });
        if (found == now.end()) {
          differences.add(pair.tonight->result.frame, name + " is not counted any more");
        } else if (!agrees(found->second, before, tolerance)) {
          differences.add(pair.tonight->result.frame,
                          fmt::format("{} {:.15g}, the baseline has {:.15g}", name, found->second, before));
        }
      }
    }
    return differences;
  }

  Differences compare_images(const std::vector<FramePair>& pairs, bool same, const CompareImages& compare) const {
    Differences differences;
    for (const FramePair& pair : pairs) {
      const std::uint32_t frame = pair.tonight->result.frame;
      const auto& now = pair.tonight->result.images;
      // The image first: of what differs, the first is told.
      std::vector<std::pair<std::string, std::string>> before(pair.baseline->result.images.begin(),
                                                              pair.baseline->result.images.end());
      std::stable_partition(before.begin(), before.end(), [](const auto& entry) { return entry.first == "image"; });
      for (const auto& [role, hash] : before) {
        const auto found = now.find(role);
        if (found == now.end()) {
          differences.add(frame, role + " is not made any more");
        } else if (role == "image" && found->second != hash) {
          const std::optional<ImageDifference> by = compare(*pair.tonight, hash);
          const std::string words = by ? fmt::format("{} pixels differ, by up to {:.4f}, mean square {:.2e}",
                                                     by->pixels, by->largest, by->mse)
                                       : std::string("it can't be compared with the baseline's");
          if (same || !by || by->mse > options_.across_image_mse) differences.add(frame, "image: " + words);
        } else if (same && found->second != hash) {
          differences.add(frame, role + " is another");
        }
      }
    }
    return differences;
  }

  // Of equal images the errors are equal too, or what measures them has changed. Images are hashed as their files' 8
  // and 16 bits, so a difference below those may show in the errors' last digits.
  static Differences compare_metrics(const std::vector<FramePair>& pairs) {
    Differences differences;
    for (const FramePair& pair : pairs) {
      if (pair.tonight->result.images != pair.baseline->result.images) continue;
      const auto before = error_values(pair.baseline->result), now = error_values(pair.tonight->result);
      for (std::size_t i = 0; i < now.size(); ++i) {
        if (std::isnan(before[i].second) || agrees(now[i].second, before[i].second, {1e-6, 0})) continue;
        differences.add(pair.tonight->result.frame,
                        fmt::format("the images are equal, but {} is {:.6g}, the baseline has {:.6g}", now[i].first,
                                    now[i].second, before[i].second));
      }
    }
    return differences;
  }

  NightCell& cell_;
  const GateOptions& options_;
};

std::vector<FramePair> pair_frames(NightCell& tonight, const NightCell& baseline, Differences& missing) {
  std::vector<FramePair> pairs;
  for (const NightFrame& before : baseline.frames) {
    const auto found = std::ranges::find_if(
        tonight.frames, [&](const NightFrame& frame) { return frame.result.frame == before.result.frame; });
    if (found == tonight.frames.end()) {
      missing.add(before.result.frame, "the baseline has it");
    } else {
      pairs.push_back({&*found, &before});
    }
  }
  return pairs;
}

// Why the two captures can't be compared at all; empty when they can.
std::string capture_difference(const NightCapture& tonight, const NightCapture& baseline) {
  if (tonight.hash != baseline.hash)
    return fmt::format("its content is {}, the baseline's {}", tonight.hash, baseline.hash);
  if (!tonight.head || !baseline.head) return "one of the two was not replayed";
  const auto setup = [](const replay::ResultsHead& head) {
    return fmt::format("{}x{}, reference of {} samples, {} point lights", head.width, head.height,
                       head.reference_samples, head.point_lights);
  };
  if (setup(*tonight.head) == setup(*baseline.head)) return "";
  return fmt::format("replayed at {}; the baseline at {}", setup(*tonight.head), setup(*baseline.head));
}

// Whether a capture is today's or yesterday's of a tag (against.hpp).
bool is_of_days(const NightRecord& night, const std::string& capture) {
  if (!night.facts.contains("against")) return false;
  for (const auto& day : night.facts.at("against").items()) {
    if (capture == day.key() || capture == yesterday_name(day.key())) return true;
  }
  return false;
}

struct CellGates {
  const GateOptions& options;
  const std::vector<TimeRound>& rounds;  // of before
  double alarm;
};

void judge_cell(NightCell& cell, const NightCapture& capture, const NightCell* before,
                const NightCapture* capture_before, const CellGates& gates, const CompareImages& compare) {
  const GateOptions& options = gates.options;
  cell.gates.clear();
  CellJudge judge(cell, options);
  judge.judge_alone(capture.problem);
  if (before == nullptr || capture_before == nullptr || cell.frames.empty()) {
    if (!cell.frames.empty()) judge.judge_error({});
    return judge.conclude(false);
  }
  const std::string difference = capture_difference(capture, *capture_before);
  if (!difference.empty()) {
    judge.add("capture", GateOutcome::failed, difference);
    // What it changed can still be looked at.
    Differences ignored;
    for (const FramePair& pair : pair_frames(cell, *before, ignored)) {
      const auto& after = pair.tonight->result.images;
      const auto now = after.find("image"), then = pair.baseline->result.images.find("image");
      if (now == after.end() || then == pair.baseline->result.images.end()) continue;
      if (now->second != then->second) compare(*pair.tonight, then->second);
    }
    judge.judge_error({});
    return judge.conclude(true);
  }
  Differences missing;
  const std::vector<FramePair> pairs = pair_frames(cell, *before, missing);
  if (missing.any()) judge.add("frames", missing, "");
  const bool same = same_class(*capture.head, *capture_before->head);
  if (!same) {
    judge.add("machine", GateOutcome::skipped,
              fmt::format("{}; the baseline is of {}: tolerances in place of equality", machine_text(*capture.head),
                          machine_text(*capture_before->head)));
  }
  judge.judge_exact(pairs, same, compare);
  judge.judge_error(pairs, same ? 0 : options.across_error);
  const bool as_fast = same_machine(*capture.head, *capture_before->head);
  judge.judge_time(gates.rounds, as_fast, gates.alarm);
  judge.judge_instructions(before->time, as_fast);
  judge.conclude(true);
}

}  // namespace

std::string machine_text(const replay::ResultsHead& head) {
  return fmt::format("{} on {}", head.driver_version, head.cpu_model);
}

CellTime cell_time(const NightCell& cell, const std::vector<NightCell>& of_same_capture) {
  const auto span_of = [](const NightCell& measured) {
    TimeSpan span;
    for (const NightFrame& frame : measured.frames) {
      span.ms += frame.result.ms.total_ms;
      span.spread_ms += frame.result.ms.spread_ms;
    }
    return span;
  };
  CellTime time{span_of(cell), {}, {}, 0};
  for (const NightFrame& frame : cell.frames) time.instructions += static_cast<double>(frame.result.ms.instructions);
  const NightCell* msaa = nullptr;
  for (const NightCell& other : of_same_capture) {
    // Only over the same frames is a ratio of sums a ratio.
    if (other.frames.size() != cell.frames.size() || other.frames.empty()) continue;
    const FrameResult& result = other.frames.front().result;
    if (result.technique == "noaa" && other.technique != cell.technique)
      time.references[other.technique] = span_of(other);
    if (result.technique == "msaa" &&
        (msaa == nullptr || (result.samples == 8 && msaa->frames[0].result.samples != 8))) {
      msaa = &other;
    }
  }
  if (msaa != nullptr && msaa->technique != cell.technique) time.references[msaa->technique] = span_of(*msaa);
  return time;
}

EarlierRounds earlier_rounds(const NightRecord& baseline, const std::vector<NightRecord>& nights) {
  EarlierRounds rounds;
  for (const NightRecord& night : nights) {
    if (night.baseline_night != baseline.id) continue;
    for (const NightCell& cell : night.cells) {
      const NightCapture& capture = night.captures.at(cell.capture);
      const auto then = std::ranges::find(baseline.captures, capture.name, &NightCapture::name);
      if (then == baseline.captures.end() || !capture_difference(capture, *then).empty() ||
          !same_machine(*capture.head, *then->head))
        continue;
      const bool passed = std::ranges::any_of(cell.gates, [](const GateResult& gate) {
        return gate.gate == "time" && gate.outcome == GateOutcome::passed;
      });
      if (!passed) continue;
      std::vector<TimeRound>& all = rounds[{capture.name, cell.technique}];
      all.insert(all.end(), cell.time.rounds.begin(), cell.time.rounds.end());
    }
  }
  return rounds;
}

void judge(NightRecord& tonight, const NightRecord* baseline, const GateOptions& options, const CompareImages& compare,
           const EarlierRounds& earlier) {
  const auto capture_of = [](const NightRecord& night, const NightCell& cell) -> const NightCapture& {
    return night.captures.at(cell.capture);
  };
  const auto counterpart = [&](const NightRecord& in, const std::string& capture,
                               const std::string& technique) -> const NightCell* {
    for (const NightCell& cell : in.cells) {
      if (cell.technique == technique && capture_of(in, cell).name == capture) return &cell;
    }
    return nullptr;
  };
  std::erase_if(tonight.cells, [](const NightCell& cell) { return cell.status == CellStatus::missing; });
  // Bonferroni: the night's rate is shared out among the cells that can raise a false alarm, and each cell's looks.
  const auto timed =
      std::ranges::count_if(tonight.cells, [](const NightCell& cell) { return !cell.time.rounds.empty(); });
  const double alarm = options.time_alarm / static_cast<double>(kTimeLooks * std::max<std::ptrdiff_t>(timed, 1));
  for (NightCell& cell : tonight.cells) {
    const NightCapture& capture = capture_of(tonight, cell);
    const NightCell* before = baseline == nullptr ? nullptr : counterpart(*baseline, capture.name, cell.technique);
    // Its capture is another one every day.
    if (is_of_days(tonight, capture.name)) before = nullptr;
    // What the baseline lacked itself is no measure.
    if (before != nullptr && before->frames.empty()) before = nullptr;
    const NightCapture* capture_before = before == nullptr ? nullptr : &capture_of(*baseline, *before);
    std::vector<TimeRound> rounds;
    if (before != nullptr) rounds = before->time.rounds;
    if (const auto later = earlier.find({capture.name, cell.technique}); later != earlier.end())
      rounds.insert(rounds.end(), later->second.begin(), later->second.end());
    judge_cell(cell, capture, before, capture_before, {options, rounds, alarm}, compare);
  }
  if (baseline == nullptr) return;
  for (const NightCell& before : baseline->cells) {
    if (before.frames.empty()) continue;
    const std::string& name = capture_of(*baseline, before).name;
    if (counterpart(tonight, name, before.technique) != nullptr || is_of_days(*baseline, name)) continue;
    NightCell missing;
    missing.technique = before.technique;
    missing.status = CellStatus::missing;
    missing.gates.push_back({"presence", GateOutcome::failed, "the baseline has it, the configuration does not"});
    const auto capture =
        std::ranges::find(tonight.captures, name, [](const NightCapture& candidate) { return candidate.name; });
    missing.capture = static_cast<std::uint32_t>(capture - tonight.captures.begin());
    if (capture == tonight.captures.end()) {
      tonight.captures.push_back({name, "not in the configuration", "", "", std::nullopt});
    }
    tonight.cells.push_back(std::move(missing));
  }
}

}  // namespace subpixel::server
