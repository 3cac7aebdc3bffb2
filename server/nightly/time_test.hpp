// Whether a technique became slower, by a test with a stated false-alarm rate.
//
// A round times every technique of a capture once, one after the other, so that the ratio of two of a round's times has
// seen the same machine. Tonight's ratios are compared with those of the nights before by the one-sided rank-sum test
// of Wilcoxon, Mann and Whitney ("On a test of whether one of two random variables is stochastically larger than the
// other", 1947), exact, so nothing is assumed of how the noise is distributed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/nightly/night.hpp"

namespace subpixel::server {

// The probability of `tonight` standing so high among both by chance when they are of one distribution: the share of
// all ways to choose tonight's ranks whose sum is as large or larger. Values that are equal count for no alarm. 1 when
// one of the two is empty.
double rank_sum_p(std::span<const double> tonight, std::span<const double> before);

// The least p that so many values can have: 1 over the number of ways to choose them.
double least_p(std::size_t tonight, std::size_t before);

enum class TimeDecision { slower, not_slower, undecided };

struct TimeVerdict {
  TimeDecision decision = TimeDecision::undecided;
  double p = 1;         // of the ratio to all references, by the mean of their logarithms
  double slowdown = 0;  // the smallest over the references: tonight's median ratio over that of before, minus 1
  std::string detail;   // in words; empty when no reference was measured both times
};

struct TimeQuestion {
  double slower = 0.05;  // share by which a ratio may rise
  double alarm = 1e-4;   // false-alarm rate of this one test
};

// Slower is what the test says of the ratio to all references together, and what is above the allowed share by the
// medians of the ratio to each; so one reference that became faster itself makes nothing else slower. not_slower: not
// above by the medians. undecided: above, but it may be chance.
TimeVerdict test_times(std::span<const TimeRound> tonight, std::span<const TimeRound> before,
                       const TimeQuestion& question);

// A cell that looks slower is judged after `rounds` of the gate and, when that did not decide, once more after so many
// times as many. Each look has its share of the false-alarm rate.
constexpr std::uint32_t kTimeLooks = 2, kMoreRounds = 3;

// Of the logarithms of a ratio over rounds: 1.4826 times the median distance from their median, which is the standard
// deviation where they are normal, and which single outliers do not move. 0 for fewer than three.
double ratio_noise(std::span<const double> log_ratios);

// Rounds that all cells get: so many that the noise of the difference of two medians is half of the share that is asked
// for, between 3 and `most`.
std::uint32_t rounds_for(double noise, double slower, std::uint32_t most);

}  // namespace subpixel::server
