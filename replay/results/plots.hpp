// Cost against error of everything a run measured: scatter plots with their Pareto front as SVG, and the points as CSV
// and Markdown. The command line writes them beside its results, the service answers with the same.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "replay/results/summary.hpp"

namespace subpixel::replay {

// time: ms of a frame. ratio: the same over that of msaa 8x, the only one that travels between machines. memory: bytes
// per pixel that the passes keep.
enum class PlotCost { time, ratio, memory };
enum class PlotError { mse, flip };
inline constexpr std::string_view kPlotCosts[] = {"time", "ratio", "memory"};
inline constexpr std::string_view kPlotErrors[] = {"mse", "flip"};

struct PlotPoint {
  std::string technique;
  std::string label;             // technique, samples, and the parameters in which its settings differ
  double x = 0, y = 0;           // cost, error: means over the frames
  double x_low = 0, x_high = 0;  // by half of the spread of the repeats
  bool on_front = false;         // nothing measured is better in one and as good in the other
};

struct Plot {
  std::string title, x_title, y_title;
  std::vector<PlotPoint> points;
};

// Settings without the error or the cost are left out; `ratio` has no points when the run has no msaa.
Plot make_plot(const std::vector<Summary>& summaries, PlotCost cost, PlotError error);

// A document of its own. Text and axes are in `currentColor`, the ground has the class `ground`, so that a page that
// embeds it can give it its own colours.
std::string to_svg(const Plot& plot);

// One line for each setting: costs, spread, ratios, errors, and on which of the fronts it is.
std::string points_csv(const std::vector<Summary>& summaries);
std::string points_markdown(const std::vector<Summary>& summaries);

// "streaming 8x surfaces=3": what tells a setting apart from the others of its technique.
std::string setting_label(const Summary& summary, const std::vector<Summary>& summaries);

}  // namespace subpixel::replay
