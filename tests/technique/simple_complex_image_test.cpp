// `simple_complex`: the list of complex pixels changes nothing, complex pixels are those of `msaa`, and the map tells
// which.
#include <algorithm>

#include "tests/technique/technique_run.hpp"
#include "tests/technique/walls.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;  // not whole tiles of the list

TEST(SimpleComplex, CompactionChangesNothing) {
  for (const int samples : {4, 8, 16, 32}) {
    const ParameterValues with{{"samples", samples}}, without{{"samples", samples}, {"compact", false}};
    const TechniqueRun compacted = run_technique(little_grass(), "simple_complex", with, kWidth, kHeight);
    EXPECT_TRUE(compacted == run_technique(little_grass(), "simple_complex", without, kWidth, kHeight)) << samples;
    expect_valid(compacted, static_cast<std::uint32_t>(samples));
  }
}

TEST(SimpleComplex, ComplexPixelsAreThoseOfMsaaAndSimpleOnesAreShadedOnce) {
  for (const int samples : {4, 8, 16, 32}) {
    const TechniqueRun run = run_technique(little_grass(), "simple_complex", {{"samples", samples}}, kWidth, kHeight);
    const TechniqueRun msaa = run_technique(little_grass(), "msaa", {{"samples", samples}}, kWidth, kHeight);
    const auto& complex = run.maps.at("complex");
    const auto count = std::ranges::count(complex, 1u);
    EXPECT_GT(count, 20);
    EXPECT_LT(count, static_cast<std::ptrdiff_t>(complex.size()) - 20);
    for (std::size_t i = 0; i < complex.size(); ++i) {
      if (complex[i] == 0) {
        ASSERT_LE(run.radiance[i].w, 1.0f) << "pixel " << i;
        ASSERT_EQ(run.radiance[i].w == 0, msaa.radiance[i].w == 0) << "pixel " << i;
        continue;
      }
      ASSERT_EQ(run.radiance[i].w, msaa.radiance[i].w) << "pixel " << i;
      // Above 8 samples `msaa` adds up group by group.
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(run.radiance[i][c], msaa.radiance[i][c], samples > 8 ? 1e-6f * (1 + msaa.radiance[i][c]) : 0.0f);
    }
    EXPECT_LT(mean_squared_difference(run, msaa), 1e-3);
    EXPECT_LT(run.executions(), msaa.executions());
  }
}

TEST(SimpleComplex, PartlyCoveredPixelsAreComplex) {
  // One triangle in front of the sky: exactly its border is complex, and there the covered samples are shaded.
  capture::Capture capture = flat_capture(32, 24);
  add_triangles(capture, {-0.8f, -0.9f, 0, 0.9f, -0.3f, 0, -0.1f, 0.8f, 0}, add_emitter(capture, {1, 1, 1}));
  const TechniqueRun run = run_technique(capture, "simple_complex", {{"samples", 8}}, 32, 24);
  const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", 8}}, 32, 24);
  for (std::size_t i = 0; i < msaa.radiance.size(); ++i) {
    const float covered = msaa.radiance[i].w;
    EXPECT_EQ(run.maps.at("complex")[i], covered > 0 && covered < 8 ? 1u : 0u) << "pixel " << i;
    EXPECT_EQ(run.radiance[i].w, covered == 8 ? 1 : covered) << "pixel " << i;
  }
}

TEST(SimpleComplex, MaterialsMakePixelsComplex) {
  // Two materials side by side in one plane, the border through the middle of a column of pixels: nothing else differs.
  capture::Capture capture = flat_capture(15, 15);
  add_triangles(capture, rectangle(-1, -1, 0, 1, 0), add_emitter(capture, {1, 1, 1}));
  add_triangles(capture, rectangle(0, -1, 1, 1, 0), add_emitter(capture, {0, 0, 1}));
  const TechniqueRun run = run_technique(capture, "simple_complex", {{"samples", 8}}, 15, 15);
  for (std::size_t i = 0; i < run.radiance.size(); ++i)
    EXPECT_EQ(run.maps.at("complex")[i], i % 15 == 7 ? 1u : 0u) << i;
}

std::uint32_t complex_where(const Walls& walls, const ParameterValues& parameters) {
  return run_technique(walls_that_meet(walls), "simple_complex", parameters, Walls::kWidth, Walls::kHeight)
      .maps.at("complex")[Walls::kMeetingPixel];
}

TEST(SimpleComplex, AnglesMakePixelsComplex) {
  EXPECT_EQ(complex_where({.left = 0.07f, .right = 0.07f}, {}), 0u);  // cos 0.14 = 0.9902
  EXPECT_EQ(complex_where({.left = 0.07f, .right = 0.08f}, {}), 1u);  // cos 0.15 = 0.9888
  EXPECT_EQ(complex_where({.left = 0.07f, .right = 0.08f}, {{"normal_threshold", 0.988}}), 0u);
}

TEST(SimpleComplex, DepthsMakePixelsComplex) {
  // These walls change by 0.0033 in depth across a pixel; half of the step is depth.
  EXPECT_EQ(complex_where({.left = 0.05f, .right = 0.05f, .step = 0.003f}, {}), 0u);
  EXPECT_EQ(complex_where({.left = 0.05f, .right = 0.05f, .step = 0.003f}, {{"depth_threshold", 0.3}}), 1u);
  EXPECT_EQ(complex_where({.left = 0.05f, .right = 0.05f, .step = 0.02f}, {}), 1u);
  EXPECT_EQ(complex_where({.left = 0.05f, .right = 0.05f, .step = 0.02f}, {{"depth_threshold", 5}}), 0u);
}

TEST(SimpleComplex, ThresholdsDecideHowManyPixelsAreComplex) {
  const auto complex = [](double depth, double normal) {
    const TechniqueRun run = run_technique(little_grass(), "simple_complex",
                                           {{"depth_threshold", depth}, {"normal_threshold", normal}}, kWidth, kHeight);
    return std::ranges::count(run.maps.at("complex"), 1u);
  };
  EXPECT_GT(complex(1, 1), complex(1, 0.9));
  EXPECT_GT(complex(0, -1), complex(100, -1));
}

TEST(SimpleComplex, MemoryIsThatOfTheStreamingPapersTable) {
  const auto bytes = [](int samples) {
    return run_technique(little_grass(), "simple_complex", {{"samples", samples}}, kWidth, kHeight)
        .paper_bytes_per_pixel;
  };
  EXPECT_EQ(bytes(8), 192);
  EXPECT_EQ(bytes(4), 96);
}

TEST(SimpleComplex, PlainSky) {
  expect_plain_sky("simple_complex", {});
}
TEST(SimpleComplex, SameOnAllThreads) {
  expect_same_on_all_threads("simple_complex", {});
}

TEST(SimpleComplex, RefusesParametersOutOfRange) {
  expect_refused("simple_complex", {{"samples", 64}});
  expect_refused("simple_complex", {{"depth_threshold", -1}});
  expect_refused("simple_complex", {{"normal_threshold", 1.5}});
  expect_refused("simple_complex", {{"compact", "sometimes"}});
}

}  // namespace
}  // namespace subpixel::replay
