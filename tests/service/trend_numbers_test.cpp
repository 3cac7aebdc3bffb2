// Trends of nights that are put into a store by hand: what a cell's numbers are, what their gates allowed, which lines
// a CSV has, and where times moved.
#include <gtest/gtest.h>

#include <cmath>

#include "server/nightly/night_store.hpp"
#include "server/nightly/trends.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::CellTrend;
using server::NightCell;
using server::NightRecord;
using server::NightStore;

NightCell a_cell() {
  NightCell cell;
  cell.technique = "fxaa";
  cell.status = server::CellStatus::passed;
  for (std::uint32_t frame = 0; frame < 2; ++frame) {
    server::NightFrame one;
    one.result.frame = frame;
    one.result.technique = "fxaa";
    one.result.ms.total_ms = 10;
    one.result.error.mse = 0.01 + 0.02 * frame;
    one.result.error.flip_mean = frame == 0 ? std::nan("") : 0.5;
    one.result.shading.executions = 100;
    one.result.memory.paper_bytes_per_pixel = 12;
    cell.frames.push_back(one);
  }
  cell.time.instructions = 1000;
  for (const double own : {1.0, 2.0, 9.0}) cell.time.rounds.push_back({own, {{"noaa", 4.0}}});
  return cell;
}

class StoredTrends : public ServiceTest {
 protected:
  StoredTrends() : claimed_(folder() / "data", server::DataFolder::Claim::night), store_(claimed_.store()) {}

  std::int64_t add(const NightCell& cell, const std::string& processor, std::optional<std::int64_t> baseline,
                   server::NightStatus status = server::NightStatus::passed) {
    NightStore nights(store_);
    NightRecord record;
    record.name = "test";
    record.commit = "a\"b,c";
    record.config = {{"name", "test"},
                     {"techniques", "fxaa"},
                     {"captures", {{{"scene", "cube"}}}},
                     {"gates",
                      {{"error", {{"mse", {{"relative", 0.01}, {"limit", 0.0205}}}, {"flip_mean", json::object()}}},
                       {"time", {{"slower", 0.05}}}}}};
    record.baseline_night = baseline;
    const std::int64_t night = nights.add(record);
    server::NightCapture capture{"cube, \"one\"", "", "hash", "", replay::ResultsHead{}};
    capture.head->driver = "llvmpipe";
    capture.head->cpu_model = processor;
    nights.add_capture(night, 0, capture);
    const std::int64_t id = nights.add_cell(night, cell);
    for (const server::NightFrame& frame : cell.frames) nights.add_frame(id, frame.result, {});
    nights.finish(night, status, "");
    return night;
  }
  CellTrend trend() { return cell_trend(NightStore(store_), "test", "cube, \"one\"", "fxaa", 100); }

  server::DataFolder claimed_;
  server::Store store_;
};

TEST(CellNumbers, AreSumsMeansAndMedians) {
  const std::map<std::string, double> numbers = server::cell_numbers(a_cell());
  EXPECT_DOUBLE_EQ(numbers.at("error.mse"), 0.02) << "the mean of its frames";
  EXPECT_EQ(numbers.at("error.flip_mean"), 0.5) << "of those that have it";
  EXPECT_EQ(numbers.count("error.flicker"), 0u) << "no frame has it";
  EXPECT_EQ(numbers.at("executions"), 200) << "their sum";
  EXPECT_EQ(numbers.at("paper_bytes_per_pixel"), 12);
  EXPECT_EQ(numbers.at("ms"), 20);
  EXPECT_EQ(numbers.at("instructions"), 1000);
  EXPECT_EQ(numbers.at("time.noaa"), 0.5) << "the median of the rounds' ratios";
}

TEST_F(StoredTrends, BandsAreWhatTheGatesAllowed) {
  const std::int64_t first = add(a_cell(), "AMD EPYC", std::nullopt);
  add(a_cell(), "AMD EPYC", first);
  add(a_cell(), "Intel Xeon", first);
  const CellTrend found = trend();
  ASSERT_EQ(found.nights.size(), 3u);
  EXPECT_TRUE(found.nights[0].bands.empty()) << "it was compared with nothing";
  const auto same = found.nights[1].bands, other = found.nights[2].bands;
  EXPECT_DOUBLE_EQ(*same.at("error.mse").high, 0.02 * 1.01) << "below the limit";
  EXPECT_DOUBLE_EQ(*other.at("error.mse").high, 0.0205) << "half more is allowed elsewhere, but not beyond the limit";
  EXPECT_DOUBLE_EQ(*other.at("error.flip_mean").high / *same.at("error.flip_mean").high, 1.5);
  EXPECT_FALSE(same.at("error.mse").low) << "a smaller error is welcome";
  EXPECT_DOUBLE_EQ(*same.at("time.noaa").high, 0.5 * 1.05);
  EXPECT_DOUBLE_EQ(*same.at("instructions").high, 1020);
  EXPECT_EQ(other.count("time.noaa") + other.count("instructions"), 0u) << "nothing is said of times elsewhere";
  EXPECT_EQ(*same.at("executions").low, 200);
  EXPECT_EQ(*same.at("executions").high, 200);
  EXPECT_DOUBLE_EQ(*other.at("executions").low, 198);
  EXPECT_DOUBLE_EQ(*other.at("executions").high, 202);
  EXPECT_EQ(same.count("ms"), 0u);
}

TEST_F(StoredTrends, CsvQuotesWhatHasToBe) {
  add(a_cell(), "x", std::nullopt);
  const std::string csv = to_csv(trend(), false);
  EXPECT_NE(csv.find(",\"a\"\"b,c\","), std::string::npos) << csv;
  EXPECT_NE(csv.find(",\"cube, \"\"one\"\"\",fxaa,executions,200,,,passed,no\r\n"), std::string::npos) << csv;
}

TEST_F(StoredTrends, CellsAreThoseOfTheNewestNightThatEnded) {
  EXPECT_TRUE(trend_cells(NightStore(store_), "test").empty());
  add(a_cell(), "x", std::nullopt);
  NightCell gone = a_cell();
  gone.technique = "smaa";
  gone.status = server::CellStatus::missing;
  add(gone, "x", std::nullopt, server::NightStatus::interrupted);
  const auto cells = trend_cells(NightStore(store_), "test");
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_EQ(cells[0].second, "fxaa");
  add(gone, "x", std::nullopt);
  EXPECT_TRUE(trend_cells(NightStore(store_), "test").empty()) << "what only the baseline had was not measured";
}

TEST_F(StoredTrends, ExactNumbersMoveAndInstructionsVary) {
  add(a_cell(), "x", std::nullopt);
  NightCell cell = a_cell();
  cell.time.instructions = 1004;
  cell.frames[0].result.ms.total_ms = 500;
  add(cell, "x", std::nullopt);
  EXPECT_TRUE(change_points(trend()).empty()) << "ms of two days mean nothing, instructions vary in their last digits";
  cell.time.instructions = 1010;
  cell.frames[0].result.counters["merges"] = 0;
  add(cell, "x", std::nullopt);
  cell.frames[0].result.counters["merges"] = 3;
  add(cell, "x", std::nullopt);
  const CellTrend found = trend();
  const std::vector<server::ChangePoint> changes = change_points(found);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].number, "counters.merges");
  EXPECT_NE(change_text(found, changes[0]).find(": 0 to 3 between"), std::string::npos) << "no share of nothing";
  EXPECT_EQ(changes[1].number, "instructions");
  EXPECT_NE(change_text(found, changes[1]).find(": 1004 to 1010 (+0.60%) between"), std::string::npos);
}

// One value a night: `levels[i]` for nights[i] nights, around which it varies a little and evenly.
CellTrend stairs(const std::vector<double>& levels, const std::vector<std::size_t>& nights) {
  CellTrend trend{"test", "one", "fxaa", {}};
  for (std::size_t level = 0; level < levels.size(); ++level) {
    for (std::size_t i = 0; i < nights[level]; ++i) {
      server::TrendNight night;
      night.id = static_cast<std::int64_t>(trend.nights.size() + 1);
      night.values["time.noaa"] = levels[level] * (1 + 0.004 * static_cast<double>((i * 5 + 4) % 8));
      trend.nights.push_back(std::move(night));
    }
  }
  return trend;
}

TEST(TimesOverNights, EveryStairIsFound) {
  // The larger side is split first, so that the other stair is left of it and then right of it.
  const std::vector<double> levels{1, 2, 3};
  for (const std::vector<std::size_t>& nights :
       {std::vector<std::size_t>{8, 8, 16}, std::vector<std::size_t>{16, 8, 8}}) {
    const std::vector<server::ChangePoint> changes = change_points(stairs(levels, nights));
    ASSERT_EQ(changes.size(), 2u);
    EXPECT_EQ(changes[0].after, nights[0]);
    EXPECT_EQ(changes[1].after, nights[0] + nights[1]);
    EXPECT_NEAR(changes[0].to / changes[0].from, 2, 1e-9) << "medians of what lies between";
    EXPECT_NEAR(changes[1].to / changes[1].from, 1.5, 1e-9);
  }
}

TEST(TimesOverNights, AGateThatFailsAgainIsNoNewChange) {
  CellTrend trend = stairs({1}, {4});
  trend.nights[2].is_slower = trend.nights[3].is_slower = true;
  const std::vector<server::ChangePoint> changes = change_points(trend);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].after, 2u);
  EXPECT_FALSE(changes[0].p);
  // Both the gate and the test say the same: one change.
  trend = stairs({1, 2}, {8, 8});
  trend.nights[8].is_slower = true;
  ASSERT_EQ(change_points(trend).size(), 1u);
  EXPECT_TRUE(change_points(trend)[0].p);
}

TEST(TimesOverNights, OneNightIsAnOutlierAndNoChange) {
  CellTrend trend = stairs({1, 1}, {8, 8});
  trend.nights[0].values["time.noaa"] = 5;
  for (const server::ChangePoint& change : change_points(trend)) EXPECT_GE(change.after, 2u);
}

}  // namespace
}  // namespace subpixel::tests
