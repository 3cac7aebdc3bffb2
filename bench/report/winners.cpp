#include "bench/report/winners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "replay/measure/advisor.hpp"

namespace subpixel::report {
namespace {

using replay::PlotError;
using replay::Summary;

constexpr double kNearMsaa = 1.1;                // times the MSE of msaa 8x
constexpr double kFlipBudgets[] = {0.03, 0.05};  // the advisor's

std::string quoted(const Summary* summary) {
  return summary == nullptr ? "none" : fmt::format("`{}`", setting_name(*summary));
}

std::string error_text(const Summary& summary, PlotError error) {
  return error == PlotError::mse ? fmt::format("{:.2f}", summary.error.mse * 1e4)
                                 : fmt::format("{:.4f}", summary.error.flip_mean);
}

// Technique by technique: "`forward` 5, `agaa` 2, nobody 1".
std::string counts(const std::map<std::string, int>& wins) {
  std::vector<std::pair<std::string, int>> sorted(wins.begin(), wins.end());
  std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [technique, count] : sorted)
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", technique.empty() ? "nobody" : "`" + technique + "`", count);
  return text;
}

std::string time_table(const Measured& measured) {
  std::string rows;
  std::map<std::string, int> wins[2];
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const std::vector<Summary> summaries = summarise(run->results);
    const Summary* msaa = replay::baseline(summaries, "msaa");
    std::string row = fmt::format("| {} |", run->plan.scene);
    for (const PlotError error : {PlotError::mse, PlotError::flip}) {
      const Summary* best = lowest_error_in_time(summaries, error);
      if (best == nullptr) break;
      ++wins[static_cast<int>(error)][best->technique];
      row += fmt::format(" {} | {} of {} | {:.2f} | {:.0f} |", quoted(best), error_text(*best, error),
                         error_text(*msaa, error), best->total_ms / msaa->total_ms, best->fitted_bytes_per_pixel);
    }
    if (row.ends_with("| |") || msaa == nullptr || std::isnan(msaa->error.mse)) continue;
    rows += row + "\n";
  }
  if (rows.empty()) return "Not measured.\n";
  return "| scene | lowest MSE | 1e-4, of `msaa` 8x | time | bytes/pixel | lowest FLIP | of `msaa` 8x | time | "
         "bytes/pixel |\n"
         "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n" +
         rows + fmt::format("\nScenes won by MSE: {}. By FLIP: {}.\n", counts(wins[0]), counts(wins[1]));
}

std::string memory_table(const Measured& measured) {
  std::string rows;
  std::map<std::string, int> wins[2];
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const std::vector<Summary> summaries = summarise(run->results);
    const auto of = [&](std::uint32_t samples) -> const Summary* {
      for (const Summary& summary : summaries)
        if (summary.technique == "msaa" && summary.samples == samples && !std::isnan(summary.error.mse))
          return &summary;
      return nullptr;
    };
    const Summary *eight = of(8), *four = of(4);
    if (eight == nullptr) continue;
    std::string row = fmt::format("| {} | {:.0f} |", run->plan.scene, eight->fitted_bytes_per_pixel);
    const double budgets[] = {kNearMsaa * eight->error.mse, four == nullptr ? std::nan("") : four->error.mse};
    for (int i = 0; i < 2; ++i) {
      const Summary* best = least_memory(summaries, PlotError::mse, budgets[i]);
      if (best == nullptr) {
        row += " none | | |";
        ++wins[i][""];
        continue;
      }
      ++wins[i][best->technique];
      row += fmt::format(" {} | {:.0f} | {:.2f} of {:.2f} |", quoted(best), best->fitted_bytes_per_pixel,
                         best->error.mse * 1e4, budgets[i] * 1e4);
    }
    rows += row + "\n";
  }
  if (rows.empty()) return "Not measured.\n";
  return fmt::format(
             "| scene | `msaa` 8x, bytes/pixel | at most {:.1f} times the MSE of `msaa` 8x | bytes/pixel | MSE, 1e-4 | "
             "at "
             "most the MSE of `msaa` 4x | bytes/pixel | MSE, 1e-4 |\n| --- | --- | --- | --- | --- | --- | --- | --- "
             "|\n",
             kNearMsaa) +
         rows + fmt::format("\nScenes won near `msaa` 8x: {}. Near 4x: {}.\n", counts(wins[0]), counts(wins[1]));
}

std::string advisor_table(const Measured& measured, double budget) {
  std::string rows;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    if (run->results.head.reference_samples == 0) continue;
    const replay::Advice advice = replay::advise(run->results, {budget, std::nullopt});
    rows += fmt::format("| {} | {} of {} |", run->plan.scene, advice.within, advice.measured);
    if (advice.closest) {
      rows += fmt::format(" none; nearest: `{}`, FLIP {:.4f} | | |\n", setting_name(*advice.closest),
                          advice.closest->error.flip_mean);
      continue;
    }
    const std::vector<Summary> summaries = summarise(run->results);
    const Summary* msaa = replay::baseline(summaries, "msaa");
    for (const replay::Choice& choice : advice.choices) {
      rows += fmt::format(" `{}`, {:.0f} B", setting_name(*choice.best), choice.best->fitted_bytes_per_pixel);
      if (msaa != nullptr) rows += fmt::format(", {:.2f}", choice.best->total_ms / msaa->total_ms);
      rows += " |";
    }
    rows += "\n";
  }
  if (rows.empty()) return "";
  return fmt::format(
             "\nBudget: a mean FLIP of {0} (`subpixel advise FILE --max-flip {0}`).\n\n"
             "| scene | settings within | by memory | by time | by both |\n| --- | --- | --- | --- | --- |\n",
             budget) +
         rows;
}

}  // namespace

std::string setting_name(const Summary& summary) {
  return setting_name(summary.technique, summary.parameters);
}

double error_of(const Summary& summary, PlotError error) {
  return error == PlotError::mse ? summary.error.mse : summary.error.flip_mean;
}

const Summary* lowest_error_in_time(const std::vector<Summary>& summaries, PlotError error) {
  const Summary* msaa = replay::baseline(summaries, "msaa");
  if (msaa == nullptr || msaa->samples != 8) return nullptr;
  const Summary* best = nullptr;
  for (const Summary& summary : summaries) {
    if (summary.total_ms > msaa->total_ms || std::isnan(error_of(summary, error))) continue;
    if (best == nullptr || error_of(summary, error) < error_of(*best, error)) best = &summary;
  }
  return best;
}

const Summary* least_memory(const std::vector<Summary>& summaries, PlotError error, double budget) {
  const Summary* best = nullptr;
  for (const Summary& summary : summaries) {
    const double value = error_of(summary, error);
    if (!(value <= budget)) continue;
    if (best == nullptr || std::pair(summary.fitted_bytes_per_pixel, value) <
                               std::pair(best->fitted_bytes_per_pixel, error_of(*best, error)))
      best = &summary;
  }
  return best;
}

std::string winners_markdown(const Measured& measured) {
  std::string text =
      "### Lowest error in at most the time of `msaa` 8x\n\n"
      "Times are over that of `msaa` 8x in the same run; bytes are those of the fitted layout.\n\n" +
      time_table(measured) + "\n### Least memory under an error budget\n\n" + memory_table(measured) +
      "\n### What the advisor says\n\nThe setting, its bytes a pixel, its time over `msaa` 8x.\n";
  for (const double budget : kFlipBudgets) text += advisor_table(measured, budget);
  return text;
}

}  // namespace subpixel::report
