#include "server/nightly/trends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "server/nightly/config.hpp"
#include "server/nightly/gates.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::string_view kTime = "time.";
constexpr std::size_t kLeastSegment = 2;  // nights on each side of a change of times
constexpr int kShuffles = 999;
constexpr double kChance = 0.01;

double median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::ranges::sort(values);
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

bool is_time(std::string_view number) {
  return number.starts_with(kTime);
}

// What the gates of `night` allowed, from the numbers of its baseline.
std::map<std::string, Band> bands_of(const std::map<std::string, double>& baseline, const GateOptions& gates,
                                     bool same_machine) {
  std::map<std::string, Band> bands;
  for (const auto& [number, before] : baseline) {
    Band band;
    if (number.starts_with("error.")) {
      const auto bound = gates.error.find(number.substr(6));
      if (bound == gates.error.end()) continue;
      const double slack = same_machine ? 0 : gates.across_error;
      band.high = before * (1 + bound->second.relative + slack) + bound->second.absolute;
      if (bound->second.limit) band.high = std::min(*band.high, *bound->second.limit);
    } else if (is_time(number)) {
      if (gates.time && same_machine) band.high = before * (1 + gates.time_slower);
    } else if (number == "instructions") {
      if (gates.time && same_machine) band.high = before * (1 + gates.instructions_more);
    } else if (number != "ms") {
      const double share = same_machine ? 0 : gates.across_relative * std::abs(before);
      band.low = before - share;
      band.high = before + share;
    }
    if (band.low || band.high) bands[number] = band;
  }
  return bands;
}

std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) ranks[order[i]] = static_cast<double>(i);
  return ranks;
}

struct Split {
  std::size_t at = 0;
  double weight = 0;
};

// The split whose sides' mean ranks are farthest apart, in units of their standard deviation by chance.
Split best_split(const std::vector<double>& ranks) {
  const double n = static_cast<double>(ranks.size()), mean = (n - 1) / 2;
  Split best;
  double sum = 0;
  for (std::size_t k = 1; k + kLeastSegment <= ranks.size(); ++k) {
    sum += ranks[k - 1] - mean;
    if (k < kLeastSegment) continue;
    const double left = static_cast<double>(k);
    const double weight = std::abs(sum) / std::sqrt(left * (n - left) * (n + 1) / 12);
    if (weight > best.weight) best = {k, weight};
  }
  return best;
}

void split_times(const std::vector<double>& values, std::size_t first, std::size_t last,
                 std::vector<std::pair<std::size_t, double>>& found) {
  if (last - first < 2 * kLeastSegment) return;
  std::vector<double> ranks = ranks_of(
      {values.begin() + static_cast<std::ptrdiff_t>(first), values.begin() + static_cast<std::ptrdiff_t>(last)});
  const Split split = best_split(ranks);
  std::mt19937 random(1);  // the same changes for the same nights
  int as_far = 0;
  for (int i = 0; i < kShuffles; ++i) {
    std::ranges::shuffle(ranks, random);
    as_far += best_split(ranks).weight >= split.weight ? 1 : 0;
  }
  const double p = static_cast<double>(as_far + 1) / (kShuffles + 1);
  if (p > kChance) return;
  split_times(values, first, first + split.at, found);
  found.emplace_back(first + split.at, p);
  split_times(values, first + split.at, last, found);
}

// The nights that have a number, and it.
struct Series {
  std::vector<std::size_t> nights;
  std::vector<double> values;
};

Series series_of(const CellTrend& trend, const std::string& number) {
  Series series;
  for (std::size_t i = 0; i < trend.nights.size(); ++i) {
    const auto found = trend.nights[i].values.find(number);
    if (found == trend.nights[i].values.end()) continue;
    series.nights.push_back(i);
    series.values.push_back(found->second);
  }
  return series;
}

void add_time_changes(const CellTrend& trend, const std::string& number, std::vector<ChangePoint>& changes) {
  const Series series = series_of(trend, number);
  std::vector<std::pair<std::size_t, double>> found;
  split_times(series.values, 0, series.values.size(), found);
  const auto part = [&](std::size_t from, std::size_t to) {
    return median({series.values.begin() + static_cast<std::ptrdiff_t>(from),
                   series.values.begin() + static_cast<std::ptrdiff_t>(to)});
  };
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : found[i - 1].first;
    const std::size_t after = i + 1 == found.size() ? series.values.size() : found[i + 1].first;
    changes.push_back({number, series.nights[found[i].first], part(before, found[i].first), part(found[i].first, after),
                       found[i].second});
  }
  for (std::size_t i = 1; i < series.nights.size(); ++i) {
    const std::size_t night = series.nights[i];
    if (!trend.nights[night].is_slower || trend.nights[series.nights[i - 1]].is_slower) continue;
    const bool known = std::ranges::any_of(
        changes, [&](const ChangePoint& change) { return change.number == number && change.after == night; });
    if (!known) changes.push_back({number, night, series.values[i - 1], series.values[i], std::nullopt});
  }
}

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

std::string number_text(const std::optional<double>& value) {
  return value ? fmt::format("{:.9g}", *value) : "";
}

std::string night_text(const TrendNight& night) {
  return night.commit.empty() ? fmt::format("night {}", night.id)
                              : fmt::format("night {} ({})", night.id, night.commit.substr(0, 12));
}

}  // namespace

std::map<std::string, double> cell_numbers(const NightCell& cell) {
  std::map<std::string, double> sums;
  std::map<std::string, std::size_t> means;  // of how many frames
  const auto mean = [&](const std::string& name, double value) {
    if (std::isnan(value)) return;
    sums[name] += value;
    ++means[name];
  };
  for (const NightFrame& frame : cell.frames) {
    const replay::FrameResult& result = frame.result;
    mean("error.mse", result.error.mse);
    mean("error.flip_mean", result.error.flip_mean);
    mean("error.flip_p99", result.error.flip_p99);
    mean("error.flip_max", result.error.flip_max);
    mean("error.hdr_rel_mse", result.error.hdr_rel_mse);
    mean("error.flicker", result.error.flicker);
    mean("paper_bytes_per_pixel", result.memory.paper_bytes_per_pixel);
    mean("fitted_bytes_per_pixel", result.memory.fitted_bytes_per_pixel);
    mean("allocated_bytes", static_cast<double>(result.memory.allocated_bytes));
    sums["executions"] += static_cast<double>(result.shading.executions);
    sums["ms"] += result.ms.total_ms;
    for (const auto& [name, value] : result.counters) sums["counters." + name] += static_cast<double>(value);
  }
  for (const auto& [name, count] : means) sums[name] /= static_cast<double>(count);
  if (cell.time.instructions > 0) sums["instructions"] = cell.time.instructions;
  std::map<std::string, std::vector<double>> ratios;
  for (const TimeRound& round : cell.time.rounds) {
    for (const auto& [reference, ms] : round.references)
      if (ms > 0) ratios[reference].push_back(round.own / ms);
  }
  for (const auto& [reference, of_rounds] : ratios) sums[std::string(kTime) + reference] = median(of_rounds);
  return sums;
}

CellTrend cell_trend(const NightStore& nights, std::string_view name, std::string_view capture,
                     std::string_view technique, std::uint32_t limit) {
  CellTrend trend{std::string(name), std::string(capture), std::string(technique), {}};
  std::vector<std::int64_t> approved;
  for (const BaselineRecord& approval : nights.approvals("")) approved.push_back(approval.night);
  std::vector<NightRecord> found = nights.nights_of_cell(name, capture, technique, limit);
  std::ranges::reverse(found);
  for (const NightRecord& night : found) {
    const NightCell& cell = night.cells.front();
    const std::optional<replay::ResultsHead>& head = night.captures.front().head;
    TrendNight one{night.id,
                   night.started_utc,
                   night.build,
                   night.commit,
                   head ? machine_text(*head) : "",
                   cell.status,
                   std::ranges::find(approved, night.id) != approved.end(),
                   cell_numbers(cell),
                   {},
                   false};
    one.is_slower = std::ranges::any_of(
        cell.gates, [](const GateResult& gate) { return gate.gate == "time" && gate.outcome == GateOutcome::failed; });
    const auto baseline = std::ranges::find(trend.nights, night.baseline_night.value_or(0), &TrendNight::id);
    if (baseline != trend.nights.end())
      one.bands = bands_of(baseline->values, gates_of(night.config), baseline->machine == one.machine);
    trend.nights.push_back(std::move(one));
  }
  return trend;
}

std::vector<std::pair<std::string, std::string>> trend_cells(const NightStore& nights, std::string_view name) {
  std::vector<std::pair<std::string, std::string>> cells;
  for (const NightRecord& night : nights.nights(20, 0, name)) {
    if (night.status != NightStatus::passed && night.status != NightStatus::failed) continue;
    for (const NightCell& cell : night.cells) {
      if (cell.status != CellStatus::missing) cells.emplace_back(night.captures.at(cell.capture).name, cell.technique);
    }
    break;
  }
  return cells;
}

std::vector<ChangePoint> change_points(const CellTrend& trend) {
  std::vector<std::string> numbers;
  for (const TrendNight& night : trend.nights) {
    for (const auto& value : night.values)
      if (std::ranges::find(numbers, value.first) == numbers.end()) numbers.push_back(value.first);
  }
  std::ranges::sort(numbers);
  std::vector<ChangePoint> changes;
  for (const std::string& number : numbers) {
    if (number == "ms") continue;  // only ratios mean anything on another day
    if (is_time(number)) {
      add_time_changes(trend, number, changes);
      continue;
    }
    const Series series = series_of(trend, number);
    // Instructions vary in their last digits.
    const double share = number == "instructions" ? 0.005 : 1e-6;
    for (std::size_t i = 1; i < series.values.size(); ++i) {
      const double from = series.values[i - 1], to = series.values[i];
      if (std::abs(to - from) > share * std::abs(from))
        changes.push_back({number, series.nights[i], from, to, std::nullopt});
    }
  }
  return changes;
}

json to_json(const CellTrend& trend) {
  json nights = json::array();
  for (const TrendNight& night : trend.nights) {
    json bands = json::object();
    for (const auto& [number, band] : night.bands) {
      bands[number] = {{"low", band.low ? json(*band.low) : json(nullptr)},
                       {"high", band.high ? json(*band.high) : json(nullptr)}};
    }
    nights.push_back({{"night", night.id},
                      {"started_utc", night.started_utc},
                      {"build", night.build},
                      {"commit", night.commit},
                      {"machine", night.machine},
                      {"status", to_text(night.status)},
                      {"approved", night.approved},
                      {"values", night.values},
                      {"bands", bands}});
  }
  json changes = json::array();
  for (const ChangePoint& change : change_points(trend)) {
    changes.push_back({{"number", change.number},
                       {"before", trend.nights[change.after - 1].id},
                       {"after", trend.nights[change.after].id},
                       {"from", change.from},
                       {"to", change.to},
                       {"p", change.p ? json(*change.p) : json(nullptr)},
                       {"text", change_text(trend, change)}});
  }
  return {{"name", trend.name},
          {"capture", trend.capture},
          {"technique", trend.technique},
          {"nights", nights},
          {"changes", changes}};
}

std::string to_csv(const CellTrend& trend, bool header) {
  std::string out =
      header ? "night,started_utc,commit,machine,capture,technique,number,value,low,high,status,approved\r\n" : "";
  for (const TrendNight& night : trend.nights) {
    for (const auto& [number, value] : night.values) {
      const auto band = night.bands.find(number);
      const Band allowed = band == night.bands.end() ? Band{} : band->second;
      out += fmt::format("{},{},{},{},{},{},{},{:.9g},{},{},{},{}\r\n", night.id, night.started_utc,
                         csv_field(night.commit), csv_field(night.machine), csv_field(trend.capture),
                         csv_field(trend.technique), csv_field(number), value, number_text(allowed.low),
                         number_text(allowed.high), to_text(night.status), night.approved ? "yes" : "no");
    }
  }
  return out;
}

std::string change_text(const CellTrend& trend, const ChangePoint& change) {
  std::string text =
      fmt::format("{} {} {}: {:.6g} to {:.6g}", trend.capture, trend.technique, change.number, change.from, change.to);
  if (change.from != 0) text += fmt::format(" ({:+.2f}%)", 100 * (change.to / change.from - 1));
  text += fmt::format(" between {} and {}", night_text(trend.nights[change.after - 1]),
                      night_text(trend.nights[change.after]));
  if (change.p) text += fmt::format(", p {:.3g}", *change.p);
  return text;
}

}  // namespace subpixel::server
