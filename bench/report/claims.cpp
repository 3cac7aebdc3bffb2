#include "bench/report/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "replay/techniques/registry.hpp"

namespace subpixel::report {

std::vector<Claim> all_claims() {
  std::vector<Claim> claims;
  for (const auto& some :
       {streaming_claims(), sbaa_claims(), agaa_claims(), dcaa_claims(), linked_list_claims(), today_claims()})
    claims.insert(claims.end(), some.begin(), some.end());
  return claims;
}

std::vector<Comparison> as_alike_as(const Measured& measured, const LookAlike& claim, double PairError::*measure) {
  std::vector<Comparison> comparisons;
  const bool flip = measure == &PairError::flip_mean;
  for (const Run* run : measured.stills()) {
    const PairError* ours = find_pair(*run, claim.test, claim.base);
    const PairError* other = find_pair(*run, claim.yardstick, claim.yardstick_base);
    if (ours == nullptr || other == nullptr) continue;
    const auto text = [&](const PairError& of) {
      return flip ? fmt::format("{:.4f}", of.flip_mean) : fmt::format("{:.2f}", of.mse * 1e4);
    };
    comparisons.push_back({run->plan.scene, "", fmt::format("{} / {}", text(*ours), text(*other)),
                           at_most(exactly(ours->*measure), claim.factor * other->*measure),
                           ours->*measure / other->*measure, run->plan.scene});
  }
  return comparisons;
}

// The mean over the frames that have a frame before.
static double mean_flicker(const Run& run, std::string_view technique, const replay::ParameterValues& given = {}) {
  const auto wanted = replay::find_technique(technique).with(given).values;
  double sum = 0;
  int count = 0;
  for (const replay::FrameResult& result : run.results.results) {
    if (result.technique != technique || result.parameters != wanted || std::isnan(result.error.flicker)) continue;
    sum += result.error.flicker;
    ++count;
  }
  return count == 0 ? std::nan("") : sum / count;
}

std::vector<Comparison> steadier_than(const Measured& measured, std::string_view technique, std::string_view other,
                                      const replay::ParameterValues& others) {
  std::vector<Comparison> comparisons;
  for (const Run* run : measured.of_kind(RunKind::frames)) {
    const double ours = mean_flicker(*run, technique), theirs = mean_flicker(*run, other, others);
    if (std::isnan(ours) || std::isnan(theirs)) continue;
    comparisons.push_back({run->plan.scene, "steadier", fmt::format("{:.5f} / {:.5f}", ours, theirs),
                           at_most(exactly(ours), theirs), ours / theirs, run->plan.scene});
  }
  return comparisons;
}

std::string range_text(const std::vector<double>& values, const char* format) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double value) { return std::isfinite(value); });
  if (finite.empty()) return "none";
  const auto [least, most] = std::ranges::minmax(finite);
  const std::string low = fmt::format(fmt::runtime(format), least), high = fmt::format(fmt::runtime(format), most);
  return low == high ? low : low + " to " + high;
}

std::string range_text(const std::vector<const Run*>& runs, const std::function<double(const Run&)>& number,
                       const char* format) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const Run* run : runs) values.push_back(number(*run));
  return range_text(values, format);
}

}  // namespace subpixel::report
