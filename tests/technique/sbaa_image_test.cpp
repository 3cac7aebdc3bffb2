// `sbaa` against `forward`, which shades all surfaces it could keep, and against what it says of itself.
#include <algorithm>

#include "tests/technique/technique_run.hpp"
#include "tests/technique/walls.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

TechniqueRun sbaa(const ParameterValues& parameters) {
  return run_technique(little_grass(), "sbaa", parameters, kWidth, kHeight);
}

TEST(Sbaa, WithoutMergingOrDroppingItShadesWhatForwardDoes) {
  const TechniqueRun run = sbaa({{"mode", "id"}, {"surfaces", 8}, {"samples", 8}});
  const TechniqueRun forward = run_technique(little_grass(), "forward", {{"samples", 8}}, kWidth, kHeight);
  expect_valid(run, 8);
  std::size_t collisions = 0;
  for (std::size_t i = 0; i < run.radiance.size(); ++i) {
    ASSERT_EQ(run.maps.at("dropped")[i], 0u);
    ASSERT_LE(run.radiance[i].w, forward.radiance[i].w) << "pixel " << i;
    collisions += run.radiance[i].w != forward.radiance[i].w ? 1 : 0;
  }
  // Two of a pixel's k triangles share one of 256 hashes in about k (k - 1) / 512 of the pixels.
  EXPECT_LT(collisions, run.radiance.size() / 20);
  EXPECT_LT(mean_squared_difference(run, forward), 1e-3);
}

TEST(Sbaa, SurfacesWithAllSamplesAreLitWhereForwardLightsThem) {
  for (const int samples : {4, 8, 16, 32}) {
    const TechniqueRun run = sbaa({{"mode", "id"}, {"samples", samples}});
    const TechniqueRun forward = run_technique(little_grass(), "forward", {{"samples", samples}}, kWidth, kHeight);
    const TechniqueRun msaa = run_technique(little_grass(), "msaa", {{"samples", samples}}, kWidth, kHeight);
    std::size_t full = 0, different = 0;
    for (std::size_t i = 0; i < run.radiance.size(); ++i) {
      if (forward.radiance[i].w != 1 || msaa.radiance[i].w != static_cast<float>(samples)) continue;
      ++full;
      for (int c = 0; c < 3; ++c)
        if (std::fabs(run.display[i][c] - forward.display[i][c]) > 0.02f) {
          ++different;
          break;
        }
    }
    EXPECT_GT(full, run.radiance.size() / 20) << samples;
    // The stored normal and albedo are rounded, and a shadow's edge may lie between two nearly equal positions.
    EXPECT_LE(different, full / 100) << samples;
  }
}

TEST(Sbaa, FewerSurfacesCostQuality) {
  const TechniqueRun exact = run_technique(little_grass(), "forward", {{"samples", 8}}, kWidth, kHeight);
  double error = 1;
  for (const int surfaces : {1, 2, 4, 8}) {
    const TechniqueRun run = sbaa({{"mode", "id"}, {"surfaces", surfaces}});
    expect_valid(run, static_cast<std::uint32_t>(surfaces));
    const double now = mean_squared_difference(run, exact);
    EXPECT_LT(now, error) << surfaces;
    error = now;
  }
}

TEST(Sbaa, CountsAddUp) {
  for (const int samples : {4, 8, 16, 32}) {
    const TechniqueRun run = sbaa({{"samples", samples}, {"surfaces", 3}});
    const TechniqueRun msaa = run_technique(little_grass(), "msaa", {{"samples", samples}}, kWidth, kHeight);
    for (std::size_t i = 0; i < run.radiance.size(); ++i) {
      ASSERT_EQ(static_cast<float>(run.maps.at("surfaces")[i]), run.radiance[i].w);
      ASSERT_EQ(run.maps.at("surfaces")[i] == 0, msaa.radiance[i].w == 0);
      // The largest surfaces are kept: at least their share of the covered samples.
      ASSERT_LE(static_cast<float>(run.maps.at("dropped")[i]), msaa.radiance[i].w - run.radiance[i].w);
    }
  }
}

TEST(Sbaa, MergingShadesLess) {
  const TechniqueRun merged = sbaa({{"surfaces", 8}}), wide = sbaa({{"surfaces", 8}, {"normal_angle", 3.0}});
  const TechniqueRun all = sbaa({{"surfaces", 8}, {"mode", "id"}});
  EXPECT_LT(merged.executions(), all.executions());
  EXPECT_LT(wide.executions(), merged.executions());
}

TEST(Sbaa, TrianglesOfOnePlaneAreOneSurface) {
  capture::Capture capture = flat_capture(16, 16);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {0.5f, 1, 2}));
  const TechniqueRun merged = run_technique(capture, "sbaa", {}, 16, 16);
  const TechniqueRun all = run_technique(capture, "sbaa", {{"mode", "id"}}, 16, 16);
  const TechniqueRun msaa = run_technique(capture, "msaa", {}, 16, 16);
  EXPECT_TRUE(std::ranges::all_of(merged.maps.at("surfaces"), [](auto count) { return count == 1; }));
  EXPECT_EQ(all.executions(), 16 * 16 + 16);  // two on the diagonal
  for (std::size_t i = 0; i < msaa.radiance.size(); ++i) {
    EXPECT_NEAR(merged.radiance[i].x, msaa.radiance[i].x, 1e-6f);
    EXPECT_NEAR(all.radiance[i].z, msaa.radiance[i].z, 1e-6f);
  }
}

std::uint32_t surfaces_where(const Walls& walls, const ParameterValues& parameters) {
  return run_technique(walls_that_meet(walls), "sbaa", parameters, Walls::kWidth, Walls::kHeight)
      .maps.at("surfaces")[Walls::kMeetingPixel];
}

TEST(Sbaa, AlignedNormalsMerge) {
  // Normals are those of the visible side, whichever way the triangles are wound.
  for (const bool turned : {false, true})
    for (const bool mirrored : {false, true}) {
      const Walls walls{.left = 0.3f, .right = 0.4f, .turned = turned, .mirrored = mirrored};
      EXPECT_EQ(surfaces_where(walls, {{"normal_angle", 0.71}}), 1u) << turned << mirrored;
      EXPECT_EQ(surfaces_where(walls, {{"normal_angle", 0.69}}), 2u) << turned << mirrored;
    }
  EXPECT_EQ(surfaces_where({.left = 0.3f, .right = 0.4f}, {{"normal_angle", 0.71}, {"mode", "id"}}), 2u);
}

TEST(Sbaa, OverlappingDepthsMerge) {
  // These walls change by 0.0067 in depth across a pixel; half of the step is depth.
  EXPECT_EQ(surfaces_where({.left = 0.1f, .right = 0.1f, .step = 0.02f}, {}), 1u);
  EXPECT_EQ(surfaces_where({.left = 0.1f, .right = 0.1f, .step = 0.1f}, {}), 2u);
  EXPECT_EQ(surfaces_where({.step = 0.001f}, {}), 2u);
}

TEST(Sbaa, DroppedSamplesDoNotShowTheSky) {
  // Four strips of white, each two primitives, share a column of pixels over a black sky: with one surface kept, the
  // column stays white.
  capture::Capture capture = flat_capture(8, 8);
  const auto white = add_emitter(capture, {1, 1, 1});
  for (const float x : {0.0f, 0.0625f, 0.125f, 0.1875f})
    add_triangles(capture, rectangle(x, -1, x + 0.0625f, 1, 0), white);
  const TechniqueRun run = run_technique(capture, "sbaa", {{"surfaces", 1}, {"mode", "id"}}, 8, 8);
  const TechniqueRun msaa = run_technique(capture, "msaa", {}, 8, 8);
  for (std::size_t i = 0; i < msaa.radiance.size(); ++i) {
    ASSERT_EQ(msaa.radiance[i].w, i % 8 == 4 ? 8 : 0);
    EXPECT_NEAR(run.radiance[i].x, msaa.radiance[i].x, 1e-6f) << "pixel " << i;
    EXPECT_EQ(run.maps.at("dropped")[i] > 0, i % 8 == 4);
  }
}

TEST(Sbaa, MemoryIsThatOfThePapers) {
  const auto bytes = [](const char* mode, int samples, int surfaces) {
    return sbaa({{"mode", mode}, {"samples", samples}, {"surfaces", surfaces}}).paper_bytes_per_pixel;
  };
  // n (depth + 1 byte) + S (16 + 2 bytes), and a normal of 2 bytes a sample where it is needed.
  EXPECT_EQ(bytes("merge", 8, 4), 8 * 7 + 4 * 18);
  EXPECT_EQ(bytes("merge", 32, 6), 32 * 7 + 6 * 18);
  EXPECT_EQ(bytes("id", 8, 4), 8 * 5 + 4 * 18);
  EXPECT_EQ(bytes("id", 4, 2), 4 * 5 + 2 * 18);
  // Aggregate paper, section 5.4: two aggregates in 37% less than S = 4.
  const double aggregates =
      run_technique(little_grass(), "agaa", {{"samples", 8}, {"aggregates", 2}}, 16, 16).paper_bytes_per_pixel;
  EXPECT_NEAR(1 - aggregates / bytes("merge", 8, 4), 0.37, 0.005);
}

TEST(Sbaa, PlainSky) {
  expect_plain_sky("sbaa", {});
}
TEST(Sbaa, SameOnAllThreads) {
  expect_same_on_all_threads("sbaa", {});
}

TEST(Sbaa, RefusesParametersOutOfRange) {
  expect_refused("sbaa", {{"samples", 64}});
  expect_refused("sbaa", {{"surfaces", 0}});
  expect_refused("sbaa", {{"surfaces", 9}});
  expect_refused("sbaa", {{"mode", "both"}});
  expect_refused("sbaa", {{"normal_angle", 4}});
}

}  // namespace
}  // namespace subpixel::replay
