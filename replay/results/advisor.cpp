#include "replay/results/advisor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace subpixel::replay {
namespace {

std::string name_of(const Summary& summary, const ParameterValues& common) {
  const std::string parameters = parameters_text(own_parameters(summary.parameters, common));
  return fmt::format("{} {}x{}{}", printable(summary.technique), summary.samples, parameters.empty() ? "" : " ",
                     parameters);
}

double cost_of(const Summary& summary, Cost cost) {
  switch (cost) {
    case Cost::memory:
      return summary.fitted_bytes;
    case Cost::time:
      return summary.total_ms;
    case Cost::both:
      break;
  }
  return summary.fitted_bytes * summary.total_ms;
}

// How many times the budget the worst frame takes; 1 or less is within. A budget of 0 asks for equal images.
double excess(const Summary& summary, const ErrorBudget& budget) {
  const auto share = [](double value, double limit) {
    if (value <= limit) return limit > 0 ? value / limit : 0.0;
    return limit > 0 ? value / limit : std::numeric_limits<double>::infinity();
  };
  double worst = 0;
  if (budget.max_flip) worst = std::max(worst, share(summary.worst_flip, *budget.max_flip));
  if (budget.max_mse) worst = std::max(worst, share(summary.worst_mse, *budget.max_mse));
  return worst;
}

std::vector<Summary> candidates(const Results& results, const ErrorBudget& budget) {
  std::vector<Summary> all = summarise(results);
  std::uint32_t frames = 0;
  for (const Summary& summary : all) frames = std::max(frames, summary.frames);
  std::erase_if(all, [&](const Summary& summary) {
    return summary.technique == "reference" || summary.frames < frames ||
           (budget.max_flip && std::isnan(summary.worst_flip)) || (budget.max_mse && std::isnan(summary.worst_mse));
  });
  return all;
}

std::string error_words(const Summary& summary, const ErrorBudget& budget) {
  std::string words;
  if (budget.max_flip) words += fmt::format("FLIP {:.4f} of {:.4f} allowed", summary.worst_flip, *budget.max_flip);
  if (budget.max_mse) {
    words +=
        fmt::format("{}MSE {:.2e} of {:.2e} allowed", words.empty() ? "" : ", ", summary.worst_mse, *budget.max_mse);
  }
  return words;
}

std::string cost_words(const Summary& summary) {
  return fmt::format("{:.1f} B/px, {:.1f} ms", summary.fitted_bytes_per_pixel, summary.total_ms);
}

std::string reason(const Choice& choice, const ErrorBudget& budget, const ParameterValues& common,
                   const Summary* msaa) {
  const Summary& best = *choice.best;
  const bool is_msaa = msaa != nullptr && best.technique == msaa->technique && best.samples == msaa->samples &&
                       best.parameters == msaa->parameters;
  std::string words = fmt::format("{}; worst frame: {}", cost_words(best), error_words(best, budget));
  if (msaa != nullptr && !is_msaa && msaa->fitted_bytes > 0 && msaa->total_ms > 0) {
    words += fmt::format("; {:.0f}% of the memory and {:.0f}% of the time of {}",
                         100 * best.fitted_bytes / msaa->fitted_bytes, 100 * best.total_ms / msaa->total_ms,
                         name_of(*msaa, common));
  }
  if (!choice.runner_up) return words + "; nothing else measured is within the budget";
  const Summary& second = *choice.runner_up;
  words += fmt::format("; then {} with {}", name_of(second, common), cost_words(second));
  const double spread = std::max(best.spread_ms, second.spread_ms);
  if (choice.cost != Cost::memory && std::abs(second.total_ms - best.total_ms) < spread) {
    words += fmt::format(" (the times differ by less than their spread of {:.1f} ms)", spread);
  }
  return words;
}

Choice choose(std::vector<Summary> within, Cost cost, const Advice& advice, const Summary* msaa) {
  // Equal cost is decided by the other cost, then by the error: less is better.
  const auto key = [&](const Summary& summary) {
    return std::tuple(cost_of(summary, cost), cost_of(summary, Cost::both), excess(summary, advice.budget));
  };
  std::ranges::stable_sort(within, [&](const Summary& a, const Summary& b) { return key(a) < key(b); });
  Choice choice;
  choice.cost = cost;
  choice.best = within.front();
  if (within.size() > 1) choice.runner_up = within[1];
  choice.reason = reason(choice, advice.budget, advice.common, msaa);
  return choice;
}

std::string_view cost_name(Cost cost) {
  switch (cost) {
    case Cost::memory:
      return "memory";
    case Cost::time:
      return "time";
    case Cost::both:
      break;
  }
  return "both";
}

nlohmann::json summary_json(const std::optional<Summary>& summary) {
  if (!summary) return nullptr;
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  return {{"technique", summary->technique},
          {"parameters", nlohmann::json(summary->parameters)},
          {"samples", summary->samples},
          {"frames", summary->frames},
          {"fitted_bytes_per_pixel", summary->fitted_bytes_per_pixel},
          {"fitted_bytes", summary->fitted_bytes},
          {"total_ms", summary->total_ms},
          {"worst_flip", number(summary->worst_flip)},
          {"worst_mse", number(summary->worst_mse)}};
}

}  // namespace

Advice advise(const Results& results, const ErrorBudget& budget) {
  const auto check = [](const std::optional<double>& limit, const char* name) {
    if (limit && !(*limit >= 0)) throw UsageError("advise", "a budget is a number of 0 or more", name);
  };
  if (!budget.max_flip && !budget.max_mse) throw UsageError("advise", "needs a budget", "--max-flip or --max-mse");
  check(budget.max_flip, "--max-flip");
  check(budget.max_mse, "--max-mse");
  const std::vector<Summary> measured = candidates(results, budget);
  if (measured.empty()) {
    throw InputError("results", "no technique was measured against a reference on every frame",
                     budget.max_flip ? "error.flip_mean" : "error.mse");
  }
  Advice advice;
  advice.budget = budget;
  advice.measured = static_cast<std::uint32_t>(measured.size());
  advice.common = common_parameters(measured);
  std::vector<Summary> within;
  std::ranges::copy_if(measured, std::back_inserter(within),
                       [&](const Summary& summary) { return excess(summary, budget) <= 1; });
  advice.within = static_cast<std::uint32_t>(within.size());
  if (within.empty()) {
    advice.closest =
        *std::ranges::min_element(measured, {}, [&](const Summary& summary) { return excess(summary, budget); });
    return advice;
  }
  const Summary* msaa = baseline(measured, "msaa");
  for (const Cost cost : {Cost::memory, Cost::time, Cost::both}) {
    advice.choices.push_back(choose(within, cost, advice, msaa));
  }
  return advice;
}

nlohmann::json to_json(const Advice& advice) {
  nlohmann::json budget = nlohmann::json::object();
  if (advice.budget.max_flip) budget["max_flip"] = *advice.budget.max_flip;
  if (advice.budget.max_mse) budget["max_mse"] = *advice.budget.max_mse;
  nlohmann::json choices = nlohmann::json::array();
  for (const Choice& choice : advice.choices) {
    choices.push_back({{"cost", cost_name(choice.cost)},
                       {"best", summary_json(choice.best)},
                       {"runner_up", summary_json(choice.runner_up)},
                       {"reason", choice.reason}});
  }
  return {{"budget", budget},
          {"measured", advice.measured},
          {"within", advice.within},
          {"choices", choices},
          {"closest", summary_json(advice.closest)}};
}

std::string to_text(const Advice& advice) {
  std::string text = fmt::format("{} of {} measured settings are within the budget.\n", advice.within, advice.measured);
  if (!advice.common.empty()) text += fmt::format("All with {}.\n", parameters_text(advice.common));
  if (advice.closest) {
    return text + fmt::format("Closest: {} (worst frame: {}).\n", name_of(*advice.closest, advice.common),
                              error_words(*advice.closest, advice.budget));
  }
  for (const Choice& choice : advice.choices) {
    text += fmt::format("by {:<7} {}\n           {}\n", cost_name(choice.cost), name_of(*choice.best, advice.common),
                        choice.reason);
  }
  return text;
}

}  // namespace subpixel::replay
