// Which technique and parameters are the cheapest that keep within an error budget, from measured results only.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "replay/results/summary.hpp"

namespace subpixel::replay {

// The mean FLIP and the MSE that no frame may exceed. At least one is given.
struct ErrorBudget {
  std::optional<double> max_flip, max_mse;
};

enum class Cost { memory, time, both };

struct Choice {
  Cost cost = Cost::memory;
  std::optional<Summary> best, runner_up;  // no runner-up when only one is within the budget
  std::string reason;                      // a sentence for people
};

struct Advice {
  ErrorBudget budget;
  std::uint32_t measured = 0;      // techniques with parameters that were measured on every frame
  std::uint32_t within = 0;        // of them, those within the budget
  ParameterValues common;          // the parameters all of them were measured with
  std::vector<Choice> choices;     // memory, time, both; empty when none is within
  std::optional<Summary> closest;  // when none is within: the one with the smallest excess
};

// Memory is what the passes keep (Memory::fitted_bytes), time the sum of the pass medians, `both` the product of the
// two. `reference` is never advised. Throws UsageError when the budget is empty or negative, InputError when the
// results don't hold the metric it is about.
Advice advise(const Results& results, const ErrorBudget& budget);

nlohmann::json to_json(const Advice& advice);
std::string to_text(const Advice& advice);

}  // namespace subpixel::replay
