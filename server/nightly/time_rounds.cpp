#include "server/nightly/time_rounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "server/nightly/time_test.hpp"

namespace subpixel::server {
namespace {

constexpr std::uint32_t kNoiseRounds = 9, kFirstRounds = 8;
// Rounds of one worker process: where a process has its memory is part of the noise, so there are several.
constexpr std::uint32_t kRoundsOfProcess = 4;
constexpr double kLeastShare = 0.02;  // a smaller share of slowness is not worth rounds without end

}  // namespace

double TimeRounds::span_of_least(const NightCell& cell, Measure measure) {
  double ms = 0;
  for (const NightFrame& frame : cell.frames) {
    ms += measure == Measure::processor_time ? frame.result.ms.processor_ms : frame.result.ms.least_ms;
  }
  return ms;
}

// `round` as `cell` sees it, unless it lacks the cell or one of its references.
void TimeRounds::add_round(NightCell& cell, const std::vector<NightCell>& round, Measure measure) {
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

void TimeRounds::measure_noise(nlohmann::json& facts) {
  for (std::size_t i = 0; i < planned_.size(); ++i) {
    if (!planned_[i].capture.problem.empty()) continue;
    std::set<std::string> references;
    for (const replay::TechniqueRequest& request : planned_[i].options.techniques) {
      const std::string key = technique_key(request.technique, request.parameters);
      if (request.technique == "noaa" || (request.technique == "msaa" && references.size() < 2)) references.insert(key);
    }
    if (references.size() < 2) continue;
    say_(fmt::format("the machine's noise: {} rounds of {}", kNoiseRounds, planned_[i].capture.name));
    std::vector<double> logs;
    for (const std::vector<NightCell>& round : time_capture(static_cast<std::uint32_t>(i), references, kNoiseRounds)) {
      const double a = span_of_least(round[0], measure_), b = span_of_least(round[1], measure_);
      if (a > 0 && b > 0) logs.push_back(std::log(a / b));
    }
    const double noise = ratio_noise(logs);
    double load = 0;
    ::getloadavg(&load, 1);
    facts["noise"] = noise;
    facts["load"] = load;
    rounds_ = rounds_for(noise, std::max(gates_.time_slower, kLeastShare), gates_.time_rounds);
    return;
  }
}

std::vector<std::vector<NightCell>> TimeRounds::time_capture(std::uint32_t capture,
                                                             const std::set<std::string>& techniques,
                                                             std::uint32_t rounds) {
  PlannedCapture planned = planned_.at(capture);
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
    if (end.head) {
      measure_ = end.head->device.starts_with("llvmpipe") ? Measure::processor_time : Measure::device_time;
    }
  };
  // Here and on no other node: times of one night are compared with those of others.
  here_.replay({request_for_(planned)}, sink);
  if (!problem.empty()) {
    say_(fmt::format("{}: times: {}", planned.capture.name, problem));
    return {};
  }
  return measured;
}

void TimeRounds::add_rounds(const Cells& wanted, std::uint32_t rounds) {
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

TimeRounds::Cells TimeRounds::worth_timing(NightRecord& night) const {
  Cells timed;
  for (NightCell& cell : night.cells) {
    if (cell.id == 0 || cell.frames.empty() || cell.time.references.empty() ||
        cell.time.own.ms < gates_.time_minimum_ms || cell.capture >= planned_.size() ||
        !night.captures[cell.capture].problem.empty())
      continue;
    timed[cell.capture].push_back(&cell);
  }
  return timed;
}

// What else the machine does comes and goes, so the rounds of a capture are spread over all of the night. Every cell
// gets as many as the noise asks for, those that look slower and the first of a baseline as many as there may be.
void TimeRounds::measure(NightRecord& night, const NightRecord* baseline, const std::function<void()>& judge) {
  const Cells timed = worth_timing(night);
  if (timed.empty()) return;
  // What may become a baseline is compared with often.
  const std::uint32_t all =
      baseline != nullptr ? rounds_ : std::min(gates_.time_rounds, std::max(kFirstRounds, 2 * rounds_));
  const auto measure = [&](const Cells& cells, std::uint32_t rounds) {
    for (std::uint32_t done = 0; done < rounds; done += kRoundsOfProcess) {
      say_(fmt::format("times: {} of {} rounds, {} captures", done, rounds, cells.size()));
      add_rounds(cells, std::min(kRoundsOfProcess, rounds - done));
    }
  };
  measure(timed, all);
  night.facts["rounds"] = all;
  night.facts["measure"] = measure_ == Measure::processor_time ? "processor time" : "device time";
  judge();
  if (baseline == nullptr || all >= gates_.time_rounds) return;
  Cells open;
  std::size_t count = 0;
  for (const auto& [capture, cells] : timed) {
    for (NightCell* cell : cells) {
      if (!looks_slower(*cell, night, *baseline)) continue;
      open[capture].push_back(cell);
      ++count;
    }
  }
  if (open.empty()) return;
  say_(fmt::format("{} cells look slower and are measured again", count));
  night.facts["measured_again"] = count;
  measure(open, gates_.time_rounds - all);
  judge();
}

bool TimeRounds::looks_slower(const NightCell& cell, const NightRecord& night, const NightRecord& baseline) const {
  const NightCell* before = nullptr;
  for (const NightCell& other : baseline.cells) {
    if (other.technique == cell.technique &&
        baseline.captures.at(other.capture).name == night.captures.at(cell.capture).name)
      before = &other;
  }
  if (before == nullptr) return false;
  const TimeVerdict verdict = test_times(cell.time.rounds, before->time.rounds, {gates_.time_slower, 0});
  return !verdict.detail.empty() && verdict.decision != TimeDecision::not_slower;
}

}  // namespace subpixel::server
