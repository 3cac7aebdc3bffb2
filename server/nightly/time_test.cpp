#include "server/nightly/time_test.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace subpixel::server {
namespace {

// Beyond so many pairs the exact distribution takes longer than it is worth.
constexpr double kExactPairs = 2000, kNormalSize = 10;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// Of each round that has all the references: the logarithm of its time less the mean of theirs.
std::vector<double> log_ratios(std::span<const TimeRound> rounds, const std::vector<std::string>& references) {
  std::vector<double> ratios;
  for (const TimeRound& round : rounds) {
    double sum = 0;
    bool complete = round.own > 0 && !references.empty();
    for (const std::string& name : references) {
      const auto found = round.references.find(name);
      complete = complete && found != round.references.end() && found->second > 0;
      if (complete) sum += std::log(found->second);
    }
    if (complete) ratios.push_back(std::log(round.own) - sum / static_cast<double>(references.size()));
  }
  return ratios;
}

// How many of the ways to choose `n` of n + m ranks have the statistic U = 0, 1, .. n m, as shares of all. By the
// recurrence of Mann and Whitney: the largest of all is tonight's or it is not.
std::vector<double> u_distribution(std::size_t n, std::size_t m) {
  std::vector<std::vector<double>> of_n(n + 1, std::vector<double>{1.0});
  // of_n[i]: for i of tonight's and j of before; j grows.
  for (std::size_t j = 1; j <= m; ++j) {
    for (std::size_t i = 1; i <= n; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(i + j);
      std::vector<double> next(i * j + 1, 0.0);
      // The largest is one of tonight's: it stands above all j, and i - 1 are left.
      const std::vector<double>& fewer = of_n[i - 1];  // of j already
      for (std::size_t u = 0; u < fewer.size(); ++u) next[u + j] += share * fewer[u];
      const std::vector<double>& same = of_n[i];  // of j - 1 still
      for (std::size_t u = 0; u < same.size(); ++u) next[u] += (1 - share) * same[u];
      of_n[i] = std::move(next);
    }
  }
  return of_n[n];
}

}  // namespace

double rank_sum_p(std::span<const double> tonight, std::span<const double> before) {
  if (tonight.empty() || before.empty()) return 1;
  std::size_t above = 0;
  for (const double now : tonight) {
    for (const double then : before) above += now > then ? 1 : 0;
  }
  const double n = static_cast<double>(tonight.size()), m = static_cast<double>(before.size());
  if (std::min(n, m) >= kNormalSize && n * m > kExactPairs) {
    // By the normal distribution, whose tail is the heavier one.
    const double deviation = std::sqrt(n * m * (n + m + 1) / 12);
    return 0.5 * std::erfc((static_cast<double>(above) - 0.5 - n * m / 2) / deviation / std::sqrt(2.0));
  }
  const std::vector<double> shares = u_distribution(tonight.size(), before.size());
  double p = 0;
  for (std::size_t u = shares.size(); u-- > above;) p += shares[u];
  return std::min(p, 1.0);
}

double least_p(std::size_t tonight, std::size_t before) {
  double p = 1;
  for (std::size_t i = 1; i <= tonight; ++i) p *= static_cast<double>(i) / static_cast<double>(before + i);
  return p;
}

TimeVerdict test_times(std::span<const TimeRound> tonight, std::span<const TimeRound> before,
                       const TimeQuestion& question) {
  TimeVerdict verdict;
  if (tonight.empty() || before.empty()) return verdict;
  std::vector<std::string> references;
  bool above_all = true;
  for (const auto& reference : tonight.front().references) {
    const std::vector<double> now = log_ratios(tonight, {reference.first});
    const std::vector<double> then = log_ratios(before, {reference.first});
    if (now.empty() || then.empty()) continue;
    const double slowdown = std::expm1(median(now) - median(then));
    above_all = above_all && slowdown > question.slower;
    verdict.slowdown = references.empty() ? slowdown : std::min(verdict.slowdown, slowdown);
    verdict.detail += fmt::format("{}{:.3f} of {}, before {:.3f} ({:+.1f}%)", verdict.detail.empty() ? "" : "; ",
                                  std::exp(median(now)), reference.first, std::exp(median(then)), 100 * slowdown);
    references.push_back(reference.first);
  }
  const std::vector<double> now = log_ratios(tonight, references);
  std::vector<double> then = log_ratios(before, references);
  if (references.empty() || now.empty() || then.empty()) return {};
  for (double& value : then) value += std::log1p(question.slower);
  verdict.p = rank_sum_p(now, then);
  verdict.detail += fmt::format("; {} and {} rounds, p {:.2g}", now.size(), then.size(), verdict.p);
  if (!above_all) {
    verdict.decision = TimeDecision::not_slower;
  } else if (verdict.p <= question.alarm) {
    verdict.decision = TimeDecision::slower;
  }
  return verdict;
}

double ratio_noise(std::span<const double> log_ratios) {
  if (log_ratios.size() < 3) return 0;
  std::vector<double> values(log_ratios.begin(), log_ratios.end());
  const double middle = median(values);
  for (double& value : values) value = std::abs(value - middle);
  return 1.4826 * median(values);
}

std::uint32_t rounds_for(double noise, double slower, std::uint32_t most) {
  // Medians of n values vary by about 1.25 noise / sqrt(n), their difference by sqrt(2) of that.
  const double wanted = slower > 0 ? std::pow(2 * 1.25 * std::sqrt(2.0) * noise / slower, 2) : 0;
  return static_cast<std::uint32_t>(
      std::clamp(std::ceil(wanted), std::min(3.0, static_cast<double>(most)), static_cast<double>(most)));
}

}  // namespace subpixel::server
