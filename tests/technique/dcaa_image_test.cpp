// `dcaa` as a whole: what it must agree with `msaa` on, its memory, and what each of its rules is for.
#include <numeric>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

std::uint64_t sum(const std::vector<std::uint32_t>& values) {
  return std::accumulate(values.begin(), values.end(), std::uint64_t{0});
}

// Without running anything.
double paper_bytes(const capture::Capture& capture, std::string_view name, const ParameterValues& given) {
  const TechniqueSetting setting = find_technique(name).with(given);
  FrameScene scene(test_device(), capture, {}, {0, kWidth, kHeight});
  FrameOutputs outputs;
  double bytes = 0;
  const FrameSetup setup(scene.frontend_frame(setting.parameters->alpha), *setting.parameters, outputs);
  for (const auto& entry : setting.technique->layout(setup)) bytes += entry.bits_per_pixel / 8;
  return bytes;
}

TEST(Dcaa, MemoryIsThatOfSection43) {
  // 4 surfaces of 28 bytes, whatever the scene. In the paper's account depth is part of a G-buffer sample of 16 bytes,
  // which makes 1024 bytes for 64 of them and 128 for 8.
  const capture::Capture capture = little_grass();
  EXPECT_EQ(paper_bytes(capture, "dcaa", {}), 112);
  EXPECT_EQ(paper_bytes(capture, "dcaa", {{"surfaces", 1}}), 28);
  EXPECT_EQ(paper_bytes(capture, "dcaa", {{"samples", 16}}), 4 * (2 + 4 + 16));
  EXPECT_EQ(paper_bytes(capture, "msaa", {{"samples", 8}}) - 8 * 4, 128);
  EXPECT_EQ(paper_bytes(capture, "msaa", {{"samples", 64}}) - 64 * 4, 1024);
}

TEST(Dcaa, AgreesWithMsaaWherePixelsHaveFewSurfaces) {
  // Squares at three depths that cross pixels: at most three surfaces anywhere, none to be merged.
  capture::Capture capture = flat_capture(40, 24);
  capture.frames[0].sky = {0.1f, 0.2f, 0.3f};
  add_triangles(capture, rectangle(-0.83f, -0.71f, 0.31f, 0.67f, -0.5f), add_emitter(capture, {1, 0.5f, 0.1f}));
  add_triangles(capture, rectangle(-0.37f, -0.93f, 0.77f, 0.11f, 0.1f), add_emitter(capture, {0.2f, 0.9f, 0.4f}));
  add_triangles(capture, {-0.91f, 0.13f, 0.6f, 0.12f, -0.53f, 0.6f, 0.57f, 0.83f, 0.6f},
                add_emitter(capture, {0.3f, 0.1f, 0.8f}));
  for (const int samples : {16, 64}) {
    const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", samples}}, 40, 24);
    for (const char* prepass : {"true", "false"}) {
      if (samples == 16 && prepass[0] == 'f') continue;
      const ParameterValues given{{"samples", samples}, {"coverage", "exact"}, {"prepass", prepass[0] == 't'}};
      const TechniqueRun run = run_technique(capture, "dcaa", given, 40, 24);
      expect_valid(run, 4);
      EXPECT_LT(mean_squared_difference(run, msaa), 1e-9) << samples << " " << prepass;
      EXPECT_EQ(sum(run.maps.at("leaks")), 0u);
    }
    const TechniqueRun table = run_technique(capture, "dcaa", {{"samples", samples}}, 40, 24);
    EXPECT_LT(mean_squared_difference(table, msaa), 1e-4) << samples;
  }
}

TEST(Dcaa, PlanesThatCrossAreResolvedAtEverySample) {
  // Two rectangles leaning against each other: who is in front changes within pixels.
  capture::Capture capture = flat_capture(16, 16);
  const std::vector<float> falling = {-1, -1, 0.9f, 1, -1, -0.9f, 1, 1, -0.8f, -1, -1, 0.9f, 1, 1, -0.8f, -1, 1, 0.85f};
  const std::vector<float> rising = {-1, -1, -0.9f, 1, -1, 0.9f, 1, 1, 0.8f, -1, -1, -0.9f, 1, 1, 0.8f, -1, 1, -0.85f};
  add_triangles(capture, falling, add_emitter(capture, {1, 0, 0}));
  add_triangles(capture, rising, add_emitter(capture, {0, 0, 1}));
  const TechniqueRun run = run_technique(capture, "dcaa", {{"coverage", "exact"}}, 16, 16);
  EXPECT_LT(mean_squared_difference(run, run_technique(capture, "msaa", {{"samples", 64}}, 16, 16)), 1e-4);
}

TEST(Dcaa, SecondMergeAndFrontMostRuleKeepWhatWouldLeak) {
  const auto run = [](const ParameterValues& given) {
    return run_technique(capture::generate("fur", {1, 64, 36, 1, 0.1}), "dcaa", given, 64, 36);
  };
  const TechniqueRun both = run({}), no_second = run({{"second_merge", "none"}}),
                     no_front = run({{"keep_front", false}});
  EXPECT_LT(sum(both.maps.at("leaks")), sum(no_second.maps.at("leaks")));
  EXPECT_LT(sum(both.maps.at("discards")), sum(no_second.maps.at("discards")));
  EXPECT_EQ(sum(no_second.maps.at("second_merges")), 0u);
  EXPECT_FALSE(both == no_front);
  expect_valid(both, 4);
}

TEST(Dcaa, NearestDiscardsNothing) {
  // Seven strips side by side at depths that do not overlap, in one pixel of a frame of 4: the paper's rules keep four.
  capture::Capture capture = flat_capture(4, 4);
  for (int i = 0; i < 7; ++i) {
    const float left = -1 + static_cast<float>(i) * 0.25f, right = i == 6 ? 1.0f : left + 0.25f;
    const float away = static_cast<float>(i);
    add_triangles(capture, rectangle(left * 0.25f - 0.25f, -1, right * 0.25f - 0.25f, 1, 0.8f - 0.2f * away),
                  add_emitter(capture, {0.1f * away, 0.5f, 0.9f - 0.1f * away}));
  }
  const TechniqueRun paper = run_technique(capture, "dcaa", {{"coverage", "exact"}}, 4, 4);
  const TechniqueRun nearest =
      run_technique(capture, "dcaa", {{"coverage", "exact"}, {"second_merge", "nearest"}}, 4, 4);
  EXPECT_GT(sum(paper.maps.at("discards")), 0u);
  EXPECT_GT(sum(paper.maps.at("leaks")), 0u);
  EXPECT_EQ(sum(nearest.maps.at("discards")), 0u);
  EXPECT_EQ(sum(nearest.maps.at("leaks")), 0u);
  expect_valid(nearest, 4);
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 64}}, 4, 4);
  EXPECT_LT(mean_squared_difference(nearest, msaa), 0.01 * mean_squared_difference(paper, msaa));
}

TEST(Dcaa, MoreSurfacesComeNearerToMsaa) {
  const capture::Capture capture = little_grass();
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 64}}, kWidth, kHeight);
  double before = 1;
  for (const int surfaces : {1, 4, 8}) {
    const TechniqueRun run = run_technique(capture, "dcaa", {{"surfaces", surfaces}}, kWidth, kHeight);
    expect_valid(run, static_cast<std::uint32_t>(surfaces));
    const double error = mean_squared_difference(run, msaa);
    EXPECT_LT(error, before) << surfaces;
    before = error;
    EXPECT_LE(*std::ranges::max_element(run.maps.at("surfaces")), static_cast<std::uint32_t>(surfaces));
  }
}

TEST(Dcaa, EmptyFramesShowTheSky) {
  expect_plain_sky("dcaa", {});
}

TEST(Dcaa, ListsLeaveTheBitsOfTheOrderedPasses) {
  // Exact masks: the table covers some samples of pixels that only the hulls of the ordered passes reach.
  expect_lists_as_ordered(
      "dcaa",
      {{{"coverage", "exact"}},
       {{"coverage", "exact"}, {"samples", 16}, {"surfaces", 1}, {"prepass", false}},
       {{"coverage", "exact"}, {"second_merge", "nearest"}},
       {{"coverage", "exact"}, {"samples", 32}, {"surfaces", 8}, {"facet_normal", "3x32"}, {"depth_bits", 32}}},
      12);
}

TEST(Dcaa, SameOnAllThreads) {
  expect_same_on_all_threads("dcaa", {{"surfaces", 6}});  // in a buffer, whose order no extension promises
}

TEST(Dcaa, RefusesWhatItCannotDo) {
  expect_refused("dcaa", {{"samples", 8}});
  expect_refused("dcaa", {{"surfaces", 9}});
  expect_refused("dcaa", {{"surfaces", 0}});
  expect_refused("dcaa", {{"table_directions", 100}});
  expect_refused("dcaa", {{"depth_bits", 25}});
  expect_refused("dcaa", {{"second_merge", "true"}});
  expect_refused("dcaa", {{"coverage", "analytic"}});
}

}  // namespace
}  // namespace subpixel::replay
