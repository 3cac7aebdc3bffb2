#include "replay/results/plots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace subpixel::replay {
namespace {

Summary setting(const std::string& technique, std::uint32_t samples, double ms, double bytes, double mse) {
  Summary summary;
  summary.technique = technique;
  summary.samples = samples;
  summary.parameters = {{"samples", samples}};
  summary.total_ms = ms;
  summary.spread_ms = 4;
  summary.fitted_bytes_per_pixel = bytes;
  summary.error.mse = mse;
  summary.error.flip_mean = std::sqrt(mse);
  return summary;
}

std::vector<Summary> measured() {
  std::vector<Summary> summaries = {setting("noaa", 1, 10, 12, 1e-2), setting("msaa", 8, 40, 96, 1e-4),
                                    setting("streaming", 8, 30, 54, 3e-4), setting("streaming", 8, 35, 72, 4e-4)};
  summaries[2].parameters["surfaces"] = 2;
  summaries[3].parameters["surfaces"] = 3;
  return summaries;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++found;
  return found;
}

TEST(Plots, FrontIsWhatNothingBeats) {
  const Plot plot = make_plot(measured(), PlotCost::time, PlotError::mse);
  ASSERT_EQ(plot.points.size(), 4U);
  EXPECT_TRUE(plot.points[0].on_front);
  EXPECT_TRUE(plot.points[1].on_front);
  EXPECT_TRUE(plot.points[2].on_front);
  EXPECT_FALSE(plot.points[3].on_front) << "dearer and worse than the one before";
}

TEST(Plots, EqualPointsAreBothOnTheFront) {
  std::vector<Summary> summaries = measured();
  summaries[3] = summaries[2];
  summaries[3].technique = "other";
  const Plot plot = make_plot(summaries, PlotCost::memory, PlotError::flip);
  EXPECT_TRUE(plot.points[2].on_front);
  EXPECT_TRUE(plot.points[3].on_front);
}

TEST(Plots, RatioIsToMsaaWithTheSpreadOfBoth) {
  const Plot plot = make_plot(measured(), PlotCost::ratio, PlotError::mse);
  EXPECT_EQ(plot.x_title, "time, as ratio to msaa 8x");
  EXPECT_DOUBLE_EQ(plot.points[2].x, 0.75);
  EXPECT_DOUBLE_EQ(plot.points[2].x_low, 28.0 / 42);
  EXPECT_DOUBLE_EQ(plot.points[2].x_high, 32.0 / 38);
  EXPECT_EQ(plot.points[1].x_low, 1) << "msaa is its own measure";
  std::vector<Summary> without = measured();
  without.erase(without.begin() + 1);
  EXPECT_TRUE(make_plot(without, PlotCost::ratio, PlotError::mse).points.empty());
}

TEST(Plots, LabelsTellSettingsOfATechniqueApart) {
  const std::vector<Summary> summaries = measured();
  EXPECT_EQ(setting_label(summaries[0], summaries), "noaa 1x");
  EXPECT_EQ(setting_label(summaries[3], summaries), "streaming 8x surfaces=3");
}

TEST(Plots, SvgHoldsEveryPointInsideOfItsFrame) {
  std::vector<Summary> summaries = measured();
  summaries[0].error.mse = 0;  // equal to the reference, on an axis that is logarithmic
  summaries[1].technique = "a<b>&c";
  const std::string svg = to_svg(make_plot(summaries, PlotCost::time, PlotError::mse));
  EXPECT_EQ(count(svg, "class=\"point\""), 4U);
  EXPECT_EQ(count(svg, "class=\"front\""), 1U);
  EXPECT_NE(svg.find("a&lt;b&gt;&amp;c 8x"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("style"), std::string::npos) << "a page's policy forbids it";
  const std::string circle = "<circle cx=\"";
  const double x = std::stod(svg.substr(svg.find(circle) + circle.size()));
  EXPECT_GE(x, 74);
  EXPECT_LE(x, 738);
}

TEST(Plots, NothingMeasuredIsSaid) {
  std::vector<Summary> summaries = measured();
  for (Summary& summary : summaries) summary.error = ImageError();
  EXPECT_NE(to_svg(make_plot(summaries, PlotCost::time, PlotError::mse)).find("Nothing was measured"),
            std::string::npos);
  EXPECT_NE(points_csv(summaries).find("streaming 8x surfaces=2"), std::string::npos);
}

TEST(Plots, TablesHaveALineForEachSetting) {
  const std::string csv = points_csv(measured());
  EXPECT_EQ(count(csv, "\r\n"), 5U);
  const std::string markdown = points_markdown(measured());
  EXPECT_EQ(count(markdown, "\n"), 6U);
  EXPECT_NE(markdown.find("| `streaming 8x surfaces=3` | 8 | 35.000 | 4.000 | 0.875 | 3.500 |"), std::string::npos)
      << markdown;
}

}  // namespace
}  // namespace subpixel::replay
