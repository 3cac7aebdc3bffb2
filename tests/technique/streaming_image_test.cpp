// `streaming` as an image: what each part of the merge metric is for, how many surfaces are needed, its memory.
#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 160, kHeight = 90;

capture::Capture scene(std::string_view name) {
  return capture::generate(name, {1, kWidth, kHeight, 1, 1.0});
}

TechniqueRun run(const capture::Capture& capture, const ParameterValues& given) {
  return run_technique(capture, "streaming", given, kWidth, kHeight);
}

// Against `msaa` with the same samples, which is what the paper compares with: only what compression changes counts.
TechniqueRun msaa(const capture::Capture& capture) {
  return run_technique(capture, "msaa", {{"samples", 8}}, kWidth, kHeight);
}

std::uint64_t total(const std::vector<std::uint32_t>& map) {
  return std::accumulate(map.begin(), map.end(), std::uint64_t{0});
}

TEST(Streaming, EachConditionOfTheMergeMetricPreventsAnArtifact) {
  // Figure 3 of the paper, top to bottom.
  for (const std::string condition : {"normals", "depth", "coverage"}) {
    const capture::Capture capture = scene("streaming_" + condition);
    const TechniqueRun exact = msaa(capture);
    const double with = mean_squared_difference(run(capture, {}), exact);
    const double without = mean_squared_difference(run(capture, {{"merge_" + condition, false}}), exact);
    EXPECT_GT(without, 4 * with) << condition;
    EXPECT_GT(without, 5e-4) << condition;
  }
}

TEST(Streaming, ATighterAngleRemovesAFalseMerge) {
  // Figure 8: light and black strips 30 degrees apart.
  const capture::Capture capture = scene("streaming_angle");
  const TechniqueRun exact = msaa(capture);
  const double given = mean_squared_difference(run(capture, {}), exact);
  const double tighter = mean_squared_difference(run(capture, {{"normal_angle", std::numbers::pi / 8}}), exact);
  EXPECT_GT(given, 1e-3);
  EXPECT_LT(tighter, given / 4);
}

TEST(Streaming, MoreSurfacesDiscardLess) {
  const capture::Capture capture = little_grass();
  const TechniqueRun exact = msaa(capture);
  double before = 1;
  std::uint64_t discarded = ~std::uint64_t{0};
  for (int surfaces = 1; surfaces <= 4; ++surfaces) {
    const ParameterValues given{{"surfaces", surfaces}};
    const TechniqueRun streaming = run(capture, given);
    expect_valid(streaming, static_cast<std::uint32_t>(surfaces));
    EXPECT_EQ(total(streaming.maps.at("order_errors")), 0u) << surfaces;
    EXPECT_LT(total(streaming.maps.at("discards")), discarded) << surfaces;
    discarded = total(streaming.maps.at("discards"));
    EXPECT_EQ(std::ranges::max(streaming.maps.at("surfaces")), static_cast<std::uint32_t>(surfaces));
    const double now = mean_squared_difference(streaming, exact);
    EXPECT_LT(now, before) << surfaces;
    before = now;
  }
}

TEST(Streaming, TheDepthTestKeepsHiddenWhatADiscardedSurfaceHid) {
  // In every pixel a black wall, then bright strips over 2, 2 and 1 of 8 samples, each at a depth of its own. The last
  // one has the fewest samples and is discarded. Where it was the wall shows, as published; the depth test knows
  // better, and leaves the sample to nobody: 4 bright samples of 7, and no sky.
  constexpr std::uint32_t kSize = 8;
  constexpr float kColumn = 2.0f / (8 * kSize);  // every eighth of a pixel's width has one sample
  capture::Capture capture = flat_capture(kSize, kSize);
  capture.frames[0].sky = {5, 5, 5};
  capture.frames[0].ambient = {0, 0, 0};
  const auto white = add_emitter(capture, {1, 1, 1}), black = add_emitter(capture, {0, 0, 0});
  add_triangles(capture, rectangle(-1, -1, 1, 1, -0.5f), black);
  const std::array ends{0.0f, 2.0f, 4.0f, 5.0f};
  for (std::size_t strip = 0; strip < 3; ++strip)
    for (std::uint32_t pixel = 0; pixel < kSize; ++pixel) {
      const float left = -1 + 8 * kColumn * static_cast<float>(pixel);
      add_triangles(capture,
                    rectangle(left + kColumn * ends[strip], -1, left + kColumn * ends[strip + 1], 1,
                              0.1f + 0.2f * static_cast<float>(strip)),
                    white);
    }
  for (const bool tested : {false, true}) {
    const TechniqueRun streaming =
        run_technique(capture, "streaming", {{"occlusion", tested ? "depth_test" : "intervals"}}, kSize, kSize);
    for (std::size_t i = 0; i < streaming.radiance.size(); ++i) {
      EXPECT_EQ(streaming.maps.at("discards")[i], 1u) << i;
      EXPECT_NEAR(streaming.radiance[i].x, tested ? 4.0f / 7 : 4.0f / 8, 1e-3f) << i;
    }
  }
}

TEST(Streaming, ShadesLessThanSimpleComplex) {
  for (const int samples : {4, 8}) {
    const ParameterValues given{{"samples", samples}};
    const capture::Capture capture = little_grass();
    const double streaming = run_technique(capture, "streaming", given, 61, 37).executions();
    const double simple_complex = run_technique(capture, "simple_complex", given, 61, 37).executions();
    EXPECT_LT(streaming, (samples == 4 ? 0.9 : 0.5) * simple_complex) << samples;
  }
}

TEST(Streaming, MemoryIsThatOfThePapersTable) {
  const auto bytes = [](int samples, int surfaces) {
    return run_technique(little_grass(), "streaming", {{"samples", samples}, {"surfaces", surfaces}}, 61, 37)
        .paper_bytes_per_pixel;
  };
  EXPECT_EQ(bytes(8, 3), 96);
  EXPECT_EQ(bytes(4, 3), 80);
  // Section 6: a sample more costs its depth and two bits of coverage in each surface; up to 16 the masks have room.
  EXPECT_EQ(bytes(16, 3), 128);
  EXPECT_EQ(bytes(8, 4), 116);
}

TEST(Streaming, ListsLeaveTheBitsOfTheOrderedPass) {
  // States in attachments and in a buffer.
  expect_lists_as_ordered("streaming",
                          {{},
                           {{"samples", 4}, {"surfaces", 1}, {"occlusion", "depth_test"}},
                           {{"samples", 32}, {"surfaces", 4}},
                           {{"alpha", "per_sample"}}},
                          20);
}

// Rectangles over all of 16x16 pixels, in no order of depth; a pixel on the diagonal has twice as many triangles.
capture::Capture layered(int layers) {
  capture::Capture capture = flat_capture(16, 16);
  const auto grey = add_emitter(capture, {0.5f, 0.5f, 0.5f}), white = add_emitter(capture, {1, 1, 1});
  for (int i = 0; i < layers; ++i) {
    const float x = static_cast<float>(i % 7) * 0.01f;
    const float depth = 0.9f * static_cast<float>((i * 37) % layers) / static_cast<float>(layers);
    add_triangles(capture, rectangle(-1 + x, -1, 1 - x, 1, depth), i % 3 == 0 ? white : grey);
  }
  return capture;
}

// A wall, then strips before it that cover the left of one column's pixels, each nearer than the one before: every one
// is nearest when it comes, and the wall, the first of all, shows at the right in the end.
capture::Capture strips_before_wall(int strips) {
  capture::Capture capture = flat_capture(16, 16);
  const auto grey = add_emitter(capture, {0.5f, 0.5f, 0.5f}), white = add_emitter(capture, {1, 1, 1});
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0.05f), grey);
  const float left = -1 + 8 * 2.0f / 16, width = 0.4f * 2.0f / 16;
  for (int i = 0; i < strips; ++i) {
    const float depth = 0.1f + 0.8f * static_cast<float>(i) / static_cast<float>(strips);
    add_triangles(capture, rectangle(left, -1, left + width, 1, depth), i % 3 == 0 ? white : grey);
  }
  return capture;
}

// Of the ordered pass, less what it counts of itself.
TechniqueRun in_one_pass(const capture::Capture& capture, const std::string& technique, ParameterValues given) {
  given["order"] = "one_pass";
  TechniqueRun run = run_technique(capture, technique, given, 16, 16);
  for (const char* map : {"words_loaded", "words_stored"}) run.maps.erase(map);
  return run;
}

void expect_lists_as_in_one_pass(const capture::Capture& capture) {
  for (const auto& [technique, given] : {std::pair<std::string, ParameterValues>{"streaming", {}},
                                         {"dcaa", {{"coverage", "exact"}}},
                                         {"dcaa", {{"coverage", "lut"}}},
                                         {"dcaa", {{"coverage", "exact"}, {"prepass", false}}},
                                         {"hybrid", {{"coverage", "exact"}}},
                                         {"hybrid", {{"coverage", "lut"}}}}) {
    const TechniqueRun lists = run_technique(capture, technique, given, 16, 16);
    EXPECT_EQ(lists.counters.count("listed_fragments"), 1u) << technique;
    EXPECT_TRUE(lists == in_one_pass(capture, technique, given)) << technique;
  }
}

TEST(Streaming, LongListsAreSortedInParts) {
  // Lists of 450, on the diagonal 900, which the heap sorts, and of 1790 and 3580, two and four parts: nearly as many
  // as there may be, on drivers that end long loops, too.
  for (const int layers : {450, 1790}) {
    SCOPED_TRACE(layers);
    expect_lists_as_in_one_pass(layered(layers));
  }
}

TEST(Streaming, LongListsAreMergedInParts) {
  // Both triangles of a strip reach every pixel of the column: 3501 fragments in some, of four parts.
  expect_lists_as_in_one_pass(strips_before_wall(1750));
}

TEST(Streaming, DeeperFramesTakeTheOrderedPass) {
  // More fragments in a pixel than shaders sort.
  const capture::Capture capture = layered(2100);
  for (const std::string technique : {"streaming", "dcaa"}) {
    const ParameterValues given = technique == "dcaa" ? ParameterValues{{"coverage", "exact"}} : ParameterValues{};
    TechniqueRun lists = run_technique(capture, technique, given, 16, 16);
    EXPECT_EQ(lists.counters.count("listed_fragments"), 0u);
    for (const char* map : {"words_loaded", "words_stored"}) lists.maps.erase(map);
    EXPECT_TRUE(lists == in_one_pass(capture, technique, given)) << technique;
  }
}

TEST(Streaming, PlainSky) {
  expect_plain_sky("streaming", {});
  expect_plain_sky("streaming", {{"samples", 32}, {"surfaces", 4}});
}
TEST(Streaming, SameOnAllThreads) {
  // States in attachments and in a buffer.
  expect_same_on_all_threads("streaming", {});
  expect_same_on_all_threads("streaming", {{"order", "one_pass"}});
  expect_same_on_all_threads("streaming", {{"samples", 32}, {"surfaces", 4}});
}

TEST(Streaming, RefusesParametersOutOfRange) {
  expect_refused("streaming", {{"surfaces", 0}});
  expect_refused("streaming", {{"surfaces", 5}});
  expect_refused("streaming", {{"samples", 64}});
  expect_refused("streaming", {{"normal_angle", 4}});
  expect_refused("streaming", {{"merge_weight", "area"}});
}

}  // namespace
}  // namespace subpixel::replay
