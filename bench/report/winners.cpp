#include "bench/report/winners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>

#include "replay/results/advisor.hpp"

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

// What the publications are about: all but the baselines, which store every sample or no G-buffer.
bool compresses(const Summary& summary) {
  constexpr std::string_view kBaselines[] = {"noaa", "fxaa", "smaa", "taa", "forward", "msaa", "simple_complex"};
  return std::ranges::find(kBaselines, summary.technique) == std::end(kBaselines);
}

std::vector<Summary> compressed(const std::vector<Summary>& summaries) {
  std::vector<Summary> kept;
  std::ranges::copy_if(summaries, std::back_inserter(kept), &compresses);
  return kept;
}

// The setting with the lowest error among `candidates` that take at most `limit_ms`.
const Summary* lowest_error(const std::vector<Summary>& candidates, PlotError error, double limit_ms) {
  const Summary* best = nullptr;
  for (const Summary& summary : candidates) {
    if (summary.total_ms > limit_ms || std::isnan(error_of(summary, error))) continue;
    if (best == nullptr || error_of(summary, error) < error_of(*best, error)) best = &summary;
  }
  return best;
}

using Wins = std::map<std::string, int>;
using Bytes = double Summary::*;

// "| `agaa c=4` | 2.81 | 0.38 | 146 |" and its technique counted.
std::string cells(const Summary* best, PlotError error, const Summary& msaa, Wins& wins, Bytes bytes) {
  ++wins[best == nullptr ? "" : best->technique];
  if (best == nullptr) return " none | | | |";
  return fmt::format(" {} | {} | {:.2f} | {:.0f} |", quoted(best), error_text(*best, error),
                     best->total_ms / msaa.total_ms, best->*bytes);
}

const Summary* msaa_of(const std::vector<Summary>& summaries, std::uint32_t samples) {
  for (const Summary& summary : summaries)
    if (summary.technique == "msaa" && summary.samples == samples && !std::isnan(summary.error.mse)) return &summary;
  return nullptr;
}

// Rows of scenes: `value` of msaa 8x, then the best of all settings and the best of those that compress. `best` picks
// one of the summaries, given all of them.
template <class Value, class Best>
std::string table(const Measured& measured, const std::string& first_column, PlotError error, Bytes bytes, Value value,
                  Best best) {
  std::string rows;
  Wins all_wins, compressed_wins;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const std::vector<Summary> summaries = summarise(run->results), some = compressed(summaries);
    const Summary* msaa = msaa_of(summaries, 8);
    if (msaa == nullptr) continue;
    const std::string budget = value(summaries, *msaa);
    if (budget.empty()) continue;
    rows += fmt::format("| {} | {} |{}{}\n", run->plan.scene, budget,
                        cells(best(summaries, summaries), error, *msaa, all_wins, bytes),
                        cells(best(some, summaries), error, *msaa, compressed_wins, bytes));
  }
  if (rows.empty()) return "Not measured.\n";
  const std::string name = error == PlotError::mse ? "MSE, 1e-4" : "FLIP";
  return fmt::format(
      "| scene | {0} | best of all | {1} | time | bytes/pixel | best that compresses | {1} | time | bytes/pixel |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n{2}\n"
      "Scenes won: {3}. Among those that compress: {4}.\n",
      first_column, name, rows, counts(all_wins), counts(compressed_wins));
}

std::string time_table(const Measured& measured, PlotError error) {
  const std::string column = error == PlotError::mse ? "`msaa` 8x: MSE" : "`msaa` 8x: FLIP";
  return table(
      measured, column, error, &Summary::fitted_bytes_per_pixel,
      [&](const std::vector<Summary>&, const Summary& msaa) { return error_text(msaa, error); },
      [&](const std::vector<Summary>& candidates, const std::vector<Summary>& all) {
        return lowest_error(candidates, error, msaa_of(all, 8)->total_ms);
      });
}

// The budget is `factor` times the MSE of msaa of so many samples.
std::string memory_table(const Measured& measured, std::uint32_t samples, double factor) {
  const auto budget = [=](const std::vector<Summary>& all) {
    const Summary* msaa = msaa_of(all, samples);
    return msaa == nullptr ? std::nan("") : factor * msaa->error.mse;
  };
  return table(
      measured, "budget", PlotError::mse, &Summary::paper_bytes_per_pixel,
      [&](const std::vector<Summary>& all, const Summary&) {
        return std::isnan(budget(all)) ? std::string() : fmt::format("{:.2f}", budget(all) * 1e4);
      },
      [&](const std::vector<Summary>& candidates, const std::vector<Summary>& all) {
        return least_memory(candidates, PlotError::mse, budget(all));
      });
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
  const Summary* msaa = msaa_of(summaries, 8);
  return msaa == nullptr ? nullptr : lowest_error(summaries, error, msaa->total_ms);
}

const Summary* least_memory(const std::vector<Summary>& summaries, PlotError error, double budget) {
  const Summary* best = nullptr;
  for (const Summary& summary : summaries) {
    const double value = error_of(summary, error);
    if (!(value <= budget)) continue;
    if (best == nullptr || std::pair(summary.paper_bytes_per_pixel, value) <
                               std::pair(best->paper_bytes_per_pixel, error_of(*best, error)))
      best = &summary;
  }
  return best;
}

namespace {

// What an engineer has to decide by, and the setting that is best then; null when none is left.
struct Question {
  const char* asks;
  const char* rule;
  std::function<const Summary*(const std::vector<Summary>&, const Summary& msaa)> best;
};

template <class Allowed>
const Summary* least_mse(const std::vector<Summary>& summaries, Allowed allowed) {
  const Summary* best = nullptr;
  for (const Summary& summary : summaries) {
    if (std::isnan(summary.error.mse) || !allowed(summary)) continue;
    if (best == nullptr || summary.error.mse < best->error.mse) best = &summary;
  }
  return best;
}

const Question kQuestions[] = {
    {"The best picture in the memory of 8x MSAA", "least MSE in at most the published bytes of `msaa` 8x",
     [](const std::vector<Summary>& all, const Summary& msaa) {
       return least_mse(all, [&](const Summary& s) { return s.paper_bytes_per_pixel <= msaa.paper_bytes_per_pixel; });
     }},
    {"The best picture lit about once a pixel", "least MSE with at most 1.5 lighting executions a pixel",
     [](const std::vector<Summary>& all, const Summary&) {
       return least_mse(all, [](const Summary& s) { return s.per_pixel_mean <= 1.5; });
     }},
    {"The best picture in half of its time", "least MSE in at most half the time of `msaa` 8x",
     [](const std::vector<Summary>& all, const Summary& msaa) {
       return least_mse(all, [&](const Summary& s) { return s.total_ms <= 0.5 * msaa.total_ms; });
     }},
    {"8x MSAA's picture in the least memory", "fewest published bytes at no more than 1.1 times its MSE",
     [](const std::vector<Summary>& all, const Summary& msaa) {
       return least_memory(all, PlotError::mse, kNearMsaa * msaa.error.mse);
     }},
    {"8x MSAA's picture in the least time", "fastest at no more than 1.1 times its MSE",
     [](const std::vector<Summary>& all, const Summary& msaa) {
       const Summary* best = nullptr;
       for (const Summary& s : all)
         if (s.error.mse <= kNearMsaa * msaa.error.mse && (best == nullptr || s.total_ms < best->total_ms)) best = &s;
       return best;
     }},
};

}  // namespace

std::string which_for_which_markdown(const Measured& measured) {
  std::string rows, title = "| frame | fragments that show, a pixel |", rule = "| --- | --- |";
  for (const Question& question : kQuestions) title += fmt::format(" {} |", question.rule), rule += " --- |";
  std::vector<Wins> wins(std::size(kQuestions));
  int frames = 0;
  for (const Run* run : measured.of_kind(RunKind::sweep)) {
    const std::vector<Summary> summaries = summarise(run->results);
    const Summary* msaa = msaa_of(summaries, 8);
    const replay::FrameResult* forward = find(*run, "forward");
    if (msaa == nullptr || forward == nullptr) continue;
    ++frames;
    rows += fmt::format("| {} | {:.2f} |", run->plan.scene, forward->shading.per_pixel_mean);
    for (std::size_t i = 0; i < std::size(kQuestions); ++i) {
      const Summary* best = kQuestions[i].best(summaries, *msaa);
      ++wins[i][best == nullptr ? "" : best->technique];
      rows += best == nullptr ? " none |"
                              : fmt::format(" `{}`: {:.2f} of the MSE, {:.0f} B, {:.2f} of the time |",
                                            setting_name(*best), best->error.mse / msaa->error.mse,
                                            best->paper_bytes_per_pixel, best->total_ms / msaa->total_ms);
    }
    rows += "\n";
  }
  if (frames == 0) return "";
  std::string answers;
  for (std::size_t i = 0; i < std::size(kQuestions); ++i)
    answers += fmt::format("- **{}** ({}): {}.\n", kQuestions[i].asks, kQuestions[i].rule, counts(wins[i]));
  return fmt::format(
             "## Which technique for which frame\n\nAt 640x360, on how many of {} frames each is the answer; every "
             "setting that was measured stands for election.\n\n",
             frames) +
         answers + "\nFrame by frame, MSE and time over `msaa` 8x, bytes a pixel of the published format:\n\n" + title +
         "\n" + rule + "\n" + rows + "\n";
}

std::string winners_markdown(const Measured& measured) {
  std::string text =
      "Times are over that of `msaa` 8x in the same run; bytes beside a time are what our passes of that time keep,\n"
      "lists and triangle numbers included; where memory decides it is the published format's. What compresses is all "
      "but the "
      "baselines.\n\n"
      "### Lowest error in at most the time of `msaa` 8x\n\n" +
      time_table(measured, PlotError::mse) + "\n" + time_table(measured, PlotError::flip) +
      fmt::format("\n### Least memory under an error budget\n\nBudget: {} times the MSE of `msaa` 8x.\n\n", kNearMsaa) +
      memory_table(measured, 8, kNearMsaa) + "\nBudget: the MSE of `msaa` 4x.\n\n" + memory_table(measured, 4, 1) +
      "\n### What the advisor says\n\nThe setting, its bytes a pixel, its time over `msaa` 8x.\n";
  for (const double budget : kFlipBudgets) text += advisor_table(measured, budget);
  return text;
}

}  // namespace subpixel::report
