#include "bench/report/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace subpixel::report {

Outcome at_most(const Interval& ours, double limit) {
  if (ours.high <= limit) return Outcome::held;
  return ours.low <= limit ? Outcome::undecided : Outcome::not_held;  // what is no number included
}

Outcome at_least(const Interval& ours, double limit) {
  if (ours.low >= limit) return Outcome::held;
  return ours.high >= limit ? Outcome::undecided : Outcome::not_held;
}

Outcome equal(double ours, double published, double tolerance) {
  return std::abs(ours - published) <= tolerance ? Outcome::held : Outcome::not_held;
}

Verdict verdict(const std::vector<Comparison>& comparisons) {
  const auto held = std::ranges::count(comparisons, Outcome::held, &Comparison::outcome);
  const auto failed = std::ranges::count(comparisons, Outcome::not_held, &Comparison::outcome);
  if (held + failed == 0) return Verdict::unknown;
  if (held == static_cast<std::ptrdiff_t>(comparisons.size())) return Verdict::all;
  return held == 0 && failed == static_cast<std::ptrdiff_t>(comparisons.size()) ? Verdict::none : Verdict::some;
}

std::string words(const std::vector<Comparison>& comparisons) {
  if (comparisons.empty()) return "not measured";
  const auto held = std::ranges::count(comparisons, Outcome::held, &Comparison::outcome);
  const auto undecided = std::ranges::count(comparisons, Outcome::undecided, &Comparison::outcome);
  const auto all = static_cast<std::ptrdiff_t>(comparisons.size());
  if (held == all) return "held";
  if (undecided == all) return "within the spread";
  const std::string open = undecided == 0 ? "" : fmt::format(", {} within the spread", undecided);
  return held == 0 ? "not held" + open : fmt::format("held on {} of {}{}", held, all, open);
}

std::string words(Outcome outcome) {
  return outcome == Outcome::held ? "yes" : outcome == Outcome::not_held ? "**no**" : "within the spread";
}

}  // namespace subpixel::report
