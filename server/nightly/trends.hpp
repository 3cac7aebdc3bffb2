// A cell's numbers over the nights of one name, what its gates allowed, and where the numbers moved.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/nightly/night_store.hpp"

namespace subpixel::server {

// What a gate allowed a number to be; a side that it leaves open is absent.
struct Band {
  std::optional<double> low, high;
};

struct TrendNight {
  std::int64_t id = 0;
  std::string started_utc, build, commit, machine;
  CellStatus status = CellStatus::unjudged;
  bool approved = false;                 // at some time, under any name
  std::map<std::string, double> values;  // by number_names' names
  std::map<std::string, Band> bands;
  bool is_slower = false;  // its time gate failed
};

struct CellTrend {
  std::string name, capture, technique;
  std::vector<TrendNight> nights;  // oldest first
};

// Where a number moved: between two stored nights.
struct ChangePoint {
  std::string number;
  std::size_t after = 0;    // the first of the trend's nights with the new number
  double from = 0, to = 0;  // of the nights around it; for times medians of those before and after
  std::optional<double> p;  // of times: how often chance does as much; absent where numbers are exact
};

// Every number of a cell: error.* and bytes are means over the frames, executions and counters.* sums, time.REFERENCE
// medians of the rounds' ratios. What was not measured is left out.
std::map<std::string, double> cell_numbers(const NightCell& cell);

// The newest `limit` nights that have the cell.
CellTrend cell_trend(const NightStore& nights, std::string_view name, std::string_view capture,
                     std::string_view technique, std::uint32_t limit);

// The cells of the newest finished night of a name, as capture and technique.
std::vector<std::pair<std::string, std::string>> trend_cells(const NightStore& nights, std::string_view name);

// Oldest first, by number. Exact numbers move when they differ. Times move where their night's gate failed first, and
// where a permutation test of the nights' medians (binary segmentation over ranks, 999 shuffles, 1%) says so.
std::vector<ChangePoint> change_points(const CellTrend& trend);

nlohmann::json to_json(const CellTrend& trend);
// night, started_utc, commit, machine, capture, technique, number, value, low, high, status, approved; RFC 4180. The
// first line has the names only when `header`.
std::string to_csv(const CellTrend& trend, bool header);
// One line for a change: "grass streaming error.mse: 0.001 to 0.002 between night 4 (abc) and night 5 (def)".
std::string change_text(const CellTrend& trend, const ChangePoint& change);

}  // namespace subpixel::server
