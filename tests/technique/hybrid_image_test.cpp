// `hybrid` as a whole: where it is `dcaa`, what its aggregates are for, and its memory.
#include <numeric>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

std::uint64_t sum(const std::vector<std::uint32_t>& values) {
  return std::accumulate(values.begin(), values.end(), std::uint64_t{0});
}

TEST(Hybrid, IsDcaaWhereNothingMerges) {
  // Lit boxes with few surfaces a pixel: what differs are 12 bits of a normal's coordinates against 16.
  const capture::Capture capture = capture::generate("cube", {.frames = 1, .width = 40, .height = 24});
  const TechniqueRun dcaa = run_technique(capture, "dcaa", {}, 40, 24);
  const TechniqueRun hybrid = run_technique(capture, "hybrid", {{"least_shown", 0}}, 40, 24);
  expect_valid(hybrid, 4);
  EXPECT_LT(mean_squared_difference(hybrid, dcaa), 1e-7);
  EXPECT_EQ(hybrid.maps.at("surfaces"), dcaa.maps.at("surfaces"));
  EXPECT_EQ(sum(hybrid.maps.at("second_merges")), 0u);
  // The old rules with mean normals are dcaa's, its bits of normals included.
  const capture::Capture grass = little_grass();
  EXPECT_EQ(run_technique(grass, "hybrid",
                          {{"second_merge", "overlapping"},
                           {"shown_only", false},
                           {"least_shown", 0},
                           {"normals", "mean"},
                           {"merge_weight", "coverage"}},
                          kWidth, kHeight),
            run_technique(grass, "dcaa", {}, kWidth, kHeight));
  EXPECT_EQ(run_technique(grass, "hybrid", {{"least_shown", 0}, {"normals", "mean"}}, kWidth, kHeight),
            run_technique(grass, "dcaa", {{"second_merge", "nearest"}}, kWidth, kHeight));
}

TEST(Hybrid, AggregatesKeepWhatDcaaDropsOrAverages) {
  constexpr std::uint32_t kWide = 160, kHigh = 90;
  const capture::Capture capture = capture::generate("grass", {1, kWide, kHigh, 1, 0.3});
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 64}}, kWide, kHigh);
  const auto error = [&](const TechniqueRun& run) { return mean_squared_difference(run, msaa); };
  const TechniqueRun dcaa = run_technique(capture, "dcaa", {}, kWide, kHigh);
  const TechniqueRun hybrid = run_technique(capture, "hybrid", {}, kWide, kHigh);
  const TechniqueRun mean = run_technique(capture, "hybrid", {{"normals", "mean"}}, kWide, kHigh);
  expect_valid(hybrid, 4);
  EXPECT_LT(error(hybrid), 0.5 * error(dcaa));
  EXPECT_LT(error(hybrid), error(mean));
  EXPECT_GT(sum(dcaa.maps.at("leaks")), 100u);
  EXPECT_LT(10 * sum(hybrid.maps.at("leaks")), sum(dcaa.maps.at("leaks")));
}

TEST(Hybrid, SurfacesThatShowLittleAreLitWithTheNearest) {
  // A strip of three columns of samples, of 64, in front of two parts of its pixel. Emitters: their mean is exact.
  capture::Capture capture = flat_capture(4, 4);
  const float column = 0.5f / 64;
  add_triangles(capture, rectangle(-1, -1, -0.25f, 1, -0.5f), add_emitter(capture, {0.25f, 0.5f, 1}));
  add_triangles(capture, rectangle(-0.25f, -1, 1, 1, 0.0f), add_emitter(capture, {1, 0.5f, 0.25f}));
  add_triangles(capture, rectangle(-0.25f - 3 * column, -1, -0.25f, 1, 0.5f), add_emitter(capture, {0.5f, 1, 0.5f}));
  const auto run = [&](double least_shown) {
    return run_technique(capture, "hybrid", {{"coverage", "exact"}, {"least_shown", least_shown}}, 4, 4);
  };
  const TechniqueRun apart = run(0), folded = run(1.0 / 16), all = run(1);
  EXPECT_EQ(apart.executions(), 4u * (1 + 3 + 1 + 1));
  EXPECT_EQ(folded.executions(), 4u * (1 + 2 + 1 + 1));
  EXPECT_EQ(all.executions(), 4u * 4);
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 64}}, 4, 4);
  for (const TechniqueRun* each : {&apart, &folded, &all}) EXPECT_LT(mean_squared_difference(*each, msaa), 1e-6);
}

TEST(Hybrid, MoreSurfacesComeNearerToMsaa) {
  const capture::Capture capture = little_grass();
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 64}}, kWidth, kHeight);
  double before = 1;
  for (const int surfaces : {1, 2, 4, 8}) {
    // Every surface that shows lit by itself: what more places bring, without the slivers that are lit with others.
    const TechniqueRun run =
        run_technique(capture, "hybrid", {{"surfaces", surfaces}, {"least_shown", 0}}, kWidth, kHeight);
    expect_valid(run, static_cast<std::uint32_t>(surfaces));
    const double error = mean_squared_difference(run, msaa);
    EXPECT_LT(error, before) << surfaces;
    before = error;
  }
}

TEST(Hybrid, EmptyFramesShowTheSky) {
  expect_plain_sky("hybrid", {});
}

TEST(Hybrid, ListsLeaveTheBitsOfTheOrderedPasses) {
  expect_lists_as_ordered("hybrid",
                          {{{"coverage", "exact"}},
                           {{"coverage", "exact"}, {"samples", 16}, {"surfaces", 1}},
                           {{"coverage", "exact"}, {"samples", 32}, {"surfaces", 8}, {"length", 0.01}}},
                          12);
}

TEST(Hybrid, SameOnAllThreads) {
  expect_same_on_all_threads("hybrid", {{"surfaces", 6}});
}

TEST(Hybrid, RefusesWhatItCannotDo) {
  expect_refused("hybrid", {{"samples", 8}});
  expect_refused("hybrid", {{"surfaces", 9}});
  expect_refused("hybrid", {{"length", 0}});
  expect_refused("hybrid", {{"merge_weight", "even"}});
  expect_refused("hybrid", {{"second_merge", "none"}});
  expect_refused("hybrid", {{"shadow_taps", 3}});
  expect_refused("hybrid", {{"least_shown", 1.5}});
}

}  // namespace
}  // namespace subpixel::replay
