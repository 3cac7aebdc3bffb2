#include "replay/results/advisor.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "replay/results/results_file.hpp"

namespace subpixel::replay {
namespace {

struct Point {
  const char* technique;
  std::uint32_t samples;
  double bytes_per_pixel, ms, flip, mse;
};

Results measured(const std::vector<Point>& points) {
  Results results;
  for (std::uint32_t frame = 0; frame < 2; ++frame) {
    for (const Point& point : points) {
      FrameResult result;
      result.frame = frame;
      result.technique = point.technique;
      result.parameters = {{"samples", point.samples}};
      result.samples = point.samples;
      result.ms.total_ms = point.ms;
      result.ms.spread_ms = 5;
      result.memory.fitted_bytes_per_pixel = point.bytes_per_pixel;
      result.memory.fitted_bytes = static_cast<std::uint64_t>(point.bytes_per_pixel * 1000);
      // The second frame is the worse one.
      result.error.flip_mean = point.flip * (frame + 1) / 2;
      result.error.mse = point.mse * (frame + 1) / 2;
      results.results.push_back(result);
    }
  }
  return results;
}

const std::vector<Point> points = {{"noaa", 1, 20, 50, 0.08, 8e-3},
                                   {"msaa", 8, 160, 400, 0.02, 1e-3},
                                   {"streaming", 8, 96, 300, 0.03, 2e-3},
                                   {"agaa", 8, 60, 420, 0.028, 1.5e-3},
                                   {"reference", 512, 1, 1, 0, 0}};

TEST(Advisor, NamesTheCheapestOfEachCostAndItsRunnerUp) {
  const Advice advice = advise(measured(points), {.max_flip = 0.03, .max_mse = {}});
  EXPECT_EQ(advice.measured, 4U);
  EXPECT_EQ(advice.within, 3U);
  ASSERT_EQ(advice.choices.size(), 3U);
  EXPECT_EQ(advice.choices[0].best->technique, "agaa");
  EXPECT_EQ(advice.choices[0].runner_up->technique, "streaming");
  EXPECT_EQ(advice.choices[1].best->technique, "streaming");
  EXPECT_EQ(advice.choices[1].runner_up->technique, "msaa");
  EXPECT_EQ(advice.choices[2].best->technique, "agaa");  // 60 * 420 against 96 * 300 and 160 * 400
  EXPECT_NE(advice.choices[0].reason.find("FLIP 0.0280 of 0.0300 allowed"), std::string::npos);
  EXPECT_NE(advice.choices[0].reason.find("38% of the memory and 105% of the time of msaa 8x"), std::string::npos);
}

TEST(Advisor, TheWorstFrameDecides) {
  EXPECT_EQ(advise(measured(points), {.max_flip = 0.0299, .max_mse = {}}).within, 2U);
  EXPECT_EQ(advise(measured(points), {.max_flip = 0.03, .max_mse = 1.2e-3}).within, 1U);
}

TEST(Advisor, SaysWhenThereIsNoOther) {
  const Advice advice = advise(measured(points), {.max_flip = {}, .max_mse = 1.2e-3});
  EXPECT_FALSE(advice.choices[0].runner_up.has_value());
  EXPECT_NE(advice.choices[0].reason.find("nothing else measured"), std::string::npos);
}

TEST(Advisor, SaysWhenTimesAreWithinTheirSpread) {
  const Advice advice = advise(measured({{"msaa", 8, 160, 400, 0.02, 1e-3}, {"sbaa", 8, 80, 398, 0.02, 1e-3}}),
                               {.max_flip = 1, .max_mse = {}});
  EXPECT_NE(advice.choices[1].reason.find("less than their spread"), std::string::npos);
  EXPECT_EQ(advice.choices[0].reason.find("less than their spread"), std::string::npos);
}

TEST(Advisor, NothingWithinTheBudgetNamesTheClosest) {
  const Advice advice = advise(measured(points), {.max_flip = 0.001, .max_mse = {}});
  EXPECT_TRUE(advice.choices.empty());
  EXPECT_EQ(advice.closest->technique, "msaa");
  EXPECT_NE(to_text(advice).find("Closest: msaa 8x"), std::string::npos);
  EXPECT_EQ(to_json(advice).at("closest").at("technique"), "msaa");
}

TEST(Advisor, SettingsNotMeasuredOnEveryFrameAreLeftOut) {
  Results results = measured(points);
  std::erase_if(results.results,
                [](const FrameResult& result) { return result.technique == "agaa" && result.frame == 1; });
  EXPECT_EQ(advise(results, {.max_flip = 0.03, .max_mse = {}}).choices[0].best->technique, "streaming");
}

TEST(Advisor, RefusesEmptyBudgetsAndUnmeasuredResults) {
  EXPECT_THROW(advise(measured(points), {}), UsageError);
  EXPECT_THROW(advise(measured(points), {.max_flip = -1, .max_mse = {}}), UsageError);
  EXPECT_THROW(advise(Results{}, {.max_flip = 1, .max_mse = {}}), InputError);
  Results unmeasured = measured(points);
  for (FrameResult& result : unmeasured.results) result.error = {};
  EXPECT_THROW(advise(unmeasured, {.max_flip = 1, .max_mse = {}}), InputError);
}

TEST(ResultsFile, ComesBackAndRefusesByNameLineAndField) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("subpixel_results_" + std::to_string(getpid()) + ".json");
  const Results results = measured(points);
  write_results(path, results);
  EXPECT_EQ(to_json(read_results(path)), to_json(results));
  const auto refusal = [&](std::string_view text) {
    write_file_atomically(path, text);
    try {
      read_results(path);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string broken = refusal("{\n \"head\": oops\n}");
  EXPECT_NE(broken.find("line 2, column 10"), std::string::npos) << broken;
  EXPECT_TRUE(broken.ends_with(path.string())) << broken;
  EXPECT_EQ(refusal("{}"), path.string() + ": results: missing field: head");
  std::filesystem::remove(path);
  EXPECT_THROW(read_results(path), InputError);
}

}  // namespace
}  // namespace subpixel::replay
