// The table of half-planes against exact edges.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "replay/techniques/dcaa_table.hpp"
#include "tests/technique/frontend_fixture.hpp"

namespace subpixel::replay {
namespace {

// The half-plane base + a x + b y >= 0 of the samples, x and y in 1/128 pixel.
std::uint64_t exact_half_plane(std::int64_t base, std::int64_t a, std::int64_t b, std::uint32_t samples) {
  std::uint64_t mask = 0;
  for (std::uint32_t i = 0; i < samples; ++i) {
    const auto [x, y] = gpu_types::sample_offset(samples, i);
    if (base + a * x + b * y >= 0) mask |= std::uint64_t{1} << i;
  }
  return mask;
}

struct Edge {
  std::int64_t base, a, b;
};

// Edges of triangles up to 40 pixels that pass within a pixel's square.
Edge random_edge(Numbers& numbers) {
  while (true) {
    const std::int64_t a = numbers.whole(-10240, 10240), b = numbers.whole(-10240, 10240);
    const std::int64_t reach = 64 * (std::abs(a) + std::abs(b));
    if (reach > 0) return {numbers.whole(-reach, reach), a, b};
  }
}

double wrong_fraction(const CoverageTableSize& size, std::uint32_t samples, int edges) {
  const auto table = coverage_table(size, samples);
  Numbers numbers(7);
  std::uint64_t wrong = 0;
  for (int k = 0; k < edges; ++k) {
    const auto [base, a, b] = random_edge(numbers);
    const std::uint32_t entry =
        coverage_table_entry(size, static_cast<double>(base), static_cast<double>(a), static_cast<double>(b));
    wrong += static_cast<std::uint64_t>(std::popcount(table[entry] ^ exact_half_plane(base, a, b, samples)));
  }
  return static_cast<double>(wrong) / (static_cast<double>(edges) * samples);
}

TEST(DcaaTable, DecidesAMillionRandomEdgesAlmostAsExactOnesDo) {
  const double wrong = wrong_fraction({}, 64, 1'000'000);
  RecordProperty("wrong_per_million", std::to_string(1e6 * wrong));
  EXPECT_GT(wrong, 1e-4);
  EXPECT_LT(wrong, 3.3e-3);
}

TEST(DcaaTable, ErrsLessTheLargerItIs) {
  const auto recorded = [](std::uint32_t directions, std::uint32_t distances) {
    const double wrong = wrong_fraction({directions, distances}, 64, 50'000);
    RecordProperty("wrong_per_million_" + std::to_string(directions), std::to_string(1e6 * wrong));
    return wrong;
  };
  const double coarse = recorded(32, 16), middle = recorded(128, 64), fine = recorded(1024, 512);
  EXPECT_LT(middle, coarse / 2);
  EXPECT_LT(fine, middle / 4);
}

TEST(DcaaTable, GivesEachSampleToOneSideOfALine) {
  for (const std::uint32_t samples : {16u, 32u, 64u}) {
    const std::uint64_t all = samples == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << samples) - 1;
    for (const CoverageTableSize size : {CoverageTableSize{}, CoverageTableSize{64, 32}}) {
      const auto table = coverage_table(size, samples);
      EXPECT_EQ(table.size(), size.entries());
      for (std::uint32_t d = 0; d < size.directions; ++d)
        for (std::uint32_t k = 0; k < size.distances + 2; ++k) {
          const std::uint32_t opposite = (d + size.directions / 2) % size.directions;
          ASSERT_EQ(
              table[d * (size.distances + 2) + k] ^ table[opposite * (size.distances + 2) + size.distances + 1 - k],
              all)
              << d << " " << k;
        }
    }
  }
}

TEST(DcaaTable, FindsOppositeEntriesForTheTwoTrianglesOfAnEdge) {
  const CoverageTableSize size;
  const auto table = coverage_table(size, 64);
  Numbers numbers(11);
  int torn = 0;
  for (int k = 0; k < 100'000; ++k) {
    const auto [base, a, b] = random_edge(numbers);
    const auto entry = [&](std::int64_t c, std::int64_t x, std::int64_t y) {
      return table[coverage_table_entry(size, static_cast<double>(c), static_cast<double>(x), static_cast<double>(y))];
    };
    // The top-left rule makes the other triangle's base -base - 1.
    torn += (entry(base, a, b) ^ entry(-base - 1, -a, -b)) == ~std::uint64_t{0} ? 0 : 1;
  }
  EXPECT_EQ(torn, 0);
}

TEST(DcaaTable, IsExactForLevelAndUprightEdges) {
  // With an entry for each column of sample positions.
  const CoverageTableSize size;
  for (const std::uint32_t samples : {32u, 64u}) {
    const auto table = coverage_table(size, samples);
    Numbers numbers(13);
    for (int k = 0; k < 20'000; ++k) {
      const std::int64_t length = numbers.whole(1, 10000) * (numbers.whole(0, 1) == 0 ? 1 : -1);
      const std::int64_t a = k % 2 == 0 ? length : 0, b = k % 2 == 0 ? 0 : length;
      const std::int64_t base = numbers.whole(-70 * std::abs(length), 70 * std::abs(length));
      ASSERT_EQ(
          table[coverage_table_entry(size, static_cast<double>(base), static_cast<double>(a), static_cast<double>(b))],
          exact_half_plane(base, a, b, samples))
          << base << " " << a << " " << b;
    }
  }
}

}  // namespace
}  // namespace subpixel::replay
