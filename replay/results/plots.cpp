#include "replay/results/plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace subpixel::replay {
namespace {

double error_of(const Summary& summary, PlotError error) {
  return error == PlotError::mse ? summary.error.mse : summary.error.flip_mean;
}

void mark_front(std::vector<PlotPoint>& points) {
  for (PlotPoint& point : points) {
    point.on_front = std::ranges::none_of(points, [&](const PlotPoint& other) {
      return other.x <= point.x && other.y <= point.y && (other.x < point.x || other.y < point.y);
    });
  }
}

PlotPoint point_of(const Summary& summary, PlotCost cost, PlotError error, const Summary* msaa) {
  PlotPoint point;
  point.technique = summary.technique;
  point.y = error_of(summary, error);
  const double half = 0.5 * summary.spread_ms;
  if (cost == PlotCost::memory) {
    point.x = point.x_low = point.x_high = summary.fitted_bytes_per_pixel;
  } else if (cost == PlotCost::time) {
    point.x = summary.total_ms;
    point.x_low = summary.total_ms - half;
    point.x_high = summary.total_ms + half;
  } else if (msaa == nullptr || !(msaa->total_ms > 0)) {
    point.x = point.x_low = point.x_high = std::numeric_limits<double>::quiet_NaN();
  } else if (msaa == &summary) {
    point.x = point.x_low = point.x_high = 1;
  } else {
    const double msaa_half = 0.5 * msaa->spread_ms;
    point.x = summary.total_ms / msaa->total_ms;
    point.x_low = (summary.total_ms - half) / (msaa->total_ms + msaa_half);
    point.x_high = (summary.total_ms + half) / std::max(msaa->total_ms - msaa_half, 0.5 * msaa->total_ms);
  }
  point.x_low = std::max(point.x_low, 0.0);
  return point;
}

// The points' table: each field as text, empty where it was not measured.
struct Row {
  std::string label;
  std::vector<std::string> numbers;
};

const std::vector<std::string> kColumns = {"samples",       "ms",         "spread ms",   "ratio to msaa",
                                           "ratio to noaa", "B/px paper", "B/px fitted", "MB allocated",
                                           "MSE",           "FLIP"};
struct FrontColumn {
  std::string_view name;
  PlotCost cost;
  PlotError error;
};
constexpr std::array<FrontColumn, 4> kFronts{{{"front time MSE", PlotCost::time, PlotError::mse},
                                              {"front time FLIP", PlotCost::time, PlotError::flip},
                                              {"front memory MSE", PlotCost::memory, PlotError::mse},
                                              {"front memory FLIP", PlotCost::memory, PlotError::flip}}};

std::string number(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : std::string();
}

std::vector<Row> rows_of(const std::vector<Summary>& summaries) {
  const Summary* msaa = baseline(summaries, "msaa");
  const Summary* noaa = baseline(summaries, "noaa");
  const auto ratio = [](const Summary& summary, const Summary* base) {
    return base == nullptr || !(base->total_ms > 0) ? std::nan("") : summary.total_ms / base->total_ms;
  };
  std::vector<Row> rows;
  rows.reserve(summaries.size());
  for (const Summary& summary : summaries) {
    rows.push_back({setting_label(summary, summaries),
                    {std::to_string(summary.samples), number(summary.total_ms, "{:.3f}"),
                     number(summary.spread_ms, "{:.3f}"), number(ratio(summary, msaa), "{:.3f}"),
                     number(ratio(summary, noaa), "{:.3f}"), number(summary.paper_bytes_per_pixel, "{:.2f}"),
                     number(summary.fitted_bytes_per_pixel, "{:.2f}"), number(summary.allocated_bytes / 1e6, "{:.3f}"),
                     number(summary.error.mse, "{:.4e}"), number(summary.error.flip_mean, "{:.5f}")}});
  }
  for (const FrontColumn& front : kFronts) {
    const Plot plot = make_plot(summaries, front.cost, front.error);
    for (Row& row : rows) {
      const auto found = std::ranges::find(plot.points, row.label, &PlotPoint::label);
      row.numbers.emplace_back(found == plot.points.end() ? "" : found->on_front ? "yes" : "no");
    }
  }
  return rows;
}

void append_quoted(std::string& out, const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

}  // namespace

std::string setting_label(const Summary& summary, const std::vector<Summary>& summaries) {
  std::vector<Summary> same;
  std::ranges::copy_if(summaries, std::back_inserter(same),
                       [&](const Summary& other) { return other.technique == summary.technique; });
  const std::string own = parameters_text(own_parameters(summary.parameters, common_parameters(same)));
  return fmt::format("{} {}x{}{}", summary.technique, summary.samples, own.empty() ? "" : " ", own);
}

Plot make_plot(const std::vector<Summary>& summaries, PlotCost cost, PlotError error) {
  Plot plot;
  const char* const costs[] = {"ms per frame", "time, as ratio to msaa", "bytes per pixel that the passes keep"};
  const char* const titles[] = {"Speed", "Speed", "Memory"};
  plot.x_title = costs[static_cast<std::size_t>(cost)];
  plot.y_title = error == PlotError::mse ? "MSE" : "FLIP, mean";
  plot.title = fmt::format("{} against error", titles[static_cast<std::size_t>(cost)]);
  const Summary* msaa = baseline(summaries, "msaa");
  if (cost == PlotCost::ratio && msaa != nullptr) plot.x_title += fmt::format(" {}x", msaa->samples);
  for (const Summary& summary : summaries) {
    PlotPoint point = point_of(summary, cost, error, msaa);
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) continue;
    point.label = setting_label(summary, summaries);
    plot.points.push_back(std::move(point));
  }
  mark_front(plot.points);
  return plot;
}

std::string points_csv(const std::vector<Summary>& summaries) {
  std::string out = "setting,parameters";
  for (const std::string& column : kColumns) out += fmt::format(",{}", column);
  for (const FrontColumn& front : kFronts) out += fmt::format(",{}", front.name);
  out += "\r\n";
  const std::vector<Row> rows = rows_of(summaries);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    append_quoted(out, rows[i].label);
    out += ',';
    append_quoted(out, parameters_text(summaries[i].parameters, ";"));
    for (const std::string& field : rows[i].numbers) out += fmt::format(",{}", field);
    out += "\r\n";
  }
  return out;
}

std::string points_markdown(const std::vector<Summary>& summaries) {
  std::string out = "| setting |";
  std::string rule = "| --- |";
  for (const std::string& column : kColumns) {
    out += fmt::format(" {} |", column);
    rule += " ---: |";
  }
  for (const FrontColumn& front : kFronts) {
    out += fmt::format(" {} |", front.name);
    rule += " --- |";
  }
  out += fmt::format("\n{}\n", rule);
  for (const Row& row : rows_of(summaries)) {
    out += fmt::format("| `{}` |", row.label);
    for (const std::string& field : row.numbers) out += fmt::format(" {} |", field);
    out += "\n";
  }
  return out;
}

}  // namespace subpixel::replay
