// The test that decides whether a technique became slower: its arithmetic by brute force, its rates on noise that was
// measured.
#include "server/nightly/time_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>

#include "tests/unit/measured_noise.hpp"

namespace subpixel::server {
namespace {

// Every way to choose which of the values are tonight's, counted.
double by_all_choices(const std::vector<double>& tonight, const std::vector<double>& before) {
  std::vector<double> all = tonight;
  all.insert(all.end(), before.begin(), before.end());
  const auto statistic = [&](std::uint32_t chosen) {
    std::size_t above = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = 0; j < all.size(); ++j)
        above += (chosen >> i & 1u) != 0 && (chosen >> j & 1u) == 0 && all[i] > all[j] ? 1 : 0;
    return above;
  };
  const std::size_t seen = statistic((1u << tonight.size()) - 1);
  std::size_t as_large = 0, count = 0;
  for (std::uint32_t chosen = 0; chosen < 1u << all.size(); ++chosen) {
    if (std::popcount(chosen) != static_cast<int>(tonight.size())) continue;
    ++count;
    as_large += statistic(chosen) >= seen ? 1 : 0;
  }
  return static_cast<double>(as_large) / static_cast<double>(count);
}

TEST(NightlyTime, RankSumIsThatOfAllChoices) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (std::size_t n = 1; n <= 5; ++n) {
    for (std::size_t m = 1; m <= 6; ++m) {
      std::vector<double> tonight(n), before(m);
      for (double& value : tonight) value = normal(random) + 0.5;
      for (double& value : before) value = normal(random);
      EXPECT_NEAR(rank_sum_p(tonight, before), by_all_choices(tonight, before), 1e-12) << n << " " << m;
    }
  }
  EXPECT_NEAR(rank_sum_p(std::vector{3.0, 4.0}, std::vector{1.0, 2.0}), 1.0 / 6, 1e-12);
  EXPECT_EQ(rank_sum_p(std::vector{1.0, 1.0}, std::vector{1.0, 1.0}), 1.0) << "equal values are no alarm";
  EXPECT_EQ(rank_sum_p({}, std::vector{1.0}), 1.0);
  EXPECT_NEAR(least_p(12, 12), 1 / 2704156.0, 1e-18);
  EXPECT_EQ(least_p(0, 5), 1.0);
}

TEST(NightlyTime, NoiseIsTheMiddleDistance) {
  const std::vector<double> logs{0, 0.01, -0.01, 0.02, -0.02, 3.0};
  EXPECT_NEAR(ratio_noise(logs), 1.4826 * 0.015, 1e-9) << "one outlier does not move it";
  EXPECT_EQ(ratio_noise(std::vector{1.0, 2.0}), 0.0);
  EXPECT_EQ(rounds_for(0, 0.03, 12), 3u);
  EXPECT_EQ(rounds_for(0.02, 0.03, 12), 6u);
  EXPECT_EQ(rounds_for(0.5, 0.03, 12), 12u);
}

// Nights made of ratios that were measured on a busy machine, in the order of chance.
class MadeUpNights {
 public:
  explicit MadeUpNights(std::uint32_t seed) : random_(seed) {}
  std::vector<TimeRound> rounds(std::size_t count, double factor) {
    std::vector<TimeRound> rounds;
    for (std::size_t i = 0; i < count; ++i) {
      const auto [to_msaa, to_noaa] = kMeasuredLogRatios[random_() % kMeasuredLogRatios.size()];
      rounds.push_back({factor, {{"msaa", std::exp(-to_msaa)}, {"noaa", std::exp(-to_noaa)}}});
    }
    return rounds;
  }

 private:
  std::mt19937 random_;
};

// The share of nights with an alarm, of four cells each of which all are slower by `factor`, judged as a night does:
// after `rounds` and, when that does not decide but the medians are above, after kMoreRounds times as many. The
// baseline and ten nights have `rounds` rounds each.
double alarms(std::size_t nights, std::size_t rounds, double factor, double alarm) {
  MadeUpNights noise(11);
  std::size_t count = 0;
  for (std::size_t night = 0; night < nights; ++night) {
    bool any = false;
    for (int cell = 0; cell < 4 && !any; ++cell) {
      const std::vector<TimeRound> before = noise.rounds(11 * rounds, 1);
      std::vector<TimeRound> tonight = noise.rounds(rounds, factor);
      const TimeQuestion question{0.03, alarm / 4 / kTimeLooks};
      TimeDecision decision = test_times(tonight, before, question).decision;
      if (decision == TimeDecision::undecided) {
        for (TimeRound& round : noise.rounds((kMoreRounds - 1) * rounds, factor)) tonight.push_back(std::move(round));
        decision = test_times(tonight, before, question).decision;
      }
      any = decision == TimeDecision::slower;
      if (factor > 1.05) break;
    }
    count += any ? 1 : 0;
  }
  return static_cast<double>(count) / static_cast<double>(nights);
}

TEST(NightlyTime, UnchangedNightsAlarmNoMoreOftenThanStated) {
  EXPECT_LE(alarms(200, 12, 1.0, 0.01), 0.01);
  // At the edge of what may be slower the rate is the stated one; of two references both have to agree, so it is below.
  EXPECT_LE(alarms(200, 12, 1.03, 0.2), 0.2);
}

TEST(NightlyTime, ATenthSlowerIsCaughtInNineOfTenNights) {
  EXPECT_GE(alarms(200, 48, 1.1, 0.01), 0.95);
}

TEST(NightlyTime, AReferenceThatOneNightLacksIsLeftOut) {
  MadeUpNights noise(3);
  std::vector<TimeRound> now = noise.rounds(12, 1.5), then = noise.rounds(12, 1);
  for (TimeRound& round : now) round.references.erase("noaa");
  EXPECT_EQ(test_times(now, then, {0.03, 0.001}).decision, TimeDecision::slower);
  for (TimeRound& round : then) round.references.erase("msaa");
  EXPECT_EQ(test_times(now, then, {0.03, 0.001}).detail, "") << "nothing that both have";
  EXPECT_EQ(test_times({}, then, {0.03, 0.001}).decision, TimeDecision::undecided);
}

}  // namespace
}  // namespace subpixel::server
