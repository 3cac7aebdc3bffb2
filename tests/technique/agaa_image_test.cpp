// `agaa` on frames: what it costs, what it agrees with, and what it does where geometry is difficult.
#include <algorithm>
#include <random>

#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

TEST(Agaa, LayoutIsThatOfThePaper) {
  capture::Capture capture = flat_capture(4, 4);
  add_triangles(capture, rectangle(-1, -1, 1, 1, 0), add_emitter(capture, {1, 1, 1}));
  const auto bytes = [&](int samples, int aggregates) {
    return run_technique(capture, "agaa", {{"samples", samples}, {"aggregates", aggregates}}, 4, 4)
        .paper_bytes_per_pixel;
  };
  // Of 16 bytes a sample, section 5.4: "a little under 40%" at 8x, "almost 50%" at 16x, and 54% at 32x in the abstract.
  EXPECT_NEAR(1 - bytes(8, 2) / (16 * 8), 0.367, 0.0005);
  EXPECT_NEAR(1 - bytes(16, 2) / (16 * 16), 0.484, 0.0005);
  EXPECT_NEAR(1 - bytes(32, 2) / (16 * 32), 0.543, 0.0005);
  EXPECT_EQ(bytes(8, 1), 16 + 6 * 8);
  EXPECT_EQ(bytes(8, 4), 4 * 16 + 6 * 8 + 2);  // figure 5: two bytes say which of four aggregates
  const auto more = [&](const char* parameter, const char* value) {
    return run_technique(capture, "agaa", {{parameter, value}}, 4, 4).paper_bytes_per_pixel - bytes(8, 2);
  };
  EXPECT_EQ(more("ndf", "sggx"), 2 * 12);
  EXPECT_EQ(more("ndf", "lean"), 2 * 16);
  EXPECT_EQ(more("shadow", "samples"), 2 * 8);
}

TEST(Agaa, IsNearBruteForceAndNearerWithMoreAggregates) {
  const TechniqueRun msaa = run_technique(little_grass(), "msaa", {{"samples", 8}}, kWidth, kHeight);
  double before = 1;
  for (int aggregates = 1; aggregates <= 4; ++aggregates) {
    const TechniqueRun run = run_technique(little_grass(), "agaa", {{"aggregates", aggregates}}, kWidth, kHeight);
    expect_valid(run, static_cast<std::uint32_t>(aggregates));
    const double error = mean_squared_difference(run, msaa);
    EXPECT_LT(error, before) << aggregates;
    before = error;
    if (aggregates == 2) {
      EXPECT_LT(error, 1e-3);
    }
    // The same samples show the sky.
    for (std::size_t i = 0; i < run.radiance.size(); ++i) {
      ASSERT_EQ(run.radiance[i].w == 0, msaa.radiance[i].w == 0) << "pixel " << i;
      ASSERT_EQ(static_cast<float>(run.maps.at("aggregates")[i]), run.radiance[i].w);
    }
  }
}

TEST(Agaa, VariantsAgree) {
  for (const int samples : {4, 32}) {
    const TechniqueRun plain = run_technique(little_grass(), "agaa", {{"samples", samples}}, kWidth, kHeight);
    expect_valid(plain, 2);
    for (const ParameterValues& variant :
         {ParameterValues{{"storage", "float"}}, ParameterValues{{"ndf", "sggx"}},
          ParameterValues{{"ndf", "sggx"}, {"storage", "float"}}, ParameterValues{{"shadow_taps", 8}},
          ParameterValues{{"ndf", "lean"}}, ParameterValues{{"ndf", "lean"}, {"storage", "float"}},
          ParameterValues{{"light_variance", true}}, ParameterValues{{"light_variance", true}, {"ndf", "lean"}},
          ParameterValues{{"shadow", "samples"}}, ParameterValues{{"shadow", "samples"}, {"storage", "float"}}}) {
      ParameterValues given = variant;
      given["samples"] = samples;
      const TechniqueRun run = run_technique(little_grass(), "agaa", given, kWidth, kHeight);
      expect_valid(run, 2);
      EXPECT_EQ(run.executions(), plain.executions());
      const double difference = mean_squared_difference(run, plain);
      EXPECT_LT(difference, 3e-4) << nlohmann::json(given).dump();
      EXPECT_GT(difference, 0) << nlohmann::json(given).dump();
    }
  }
}

TEST(Agaa, SeparationSparesAggregates) {
  const auto run = [](double separation) {
    return run_technique(little_grass(), "agaa", {{"separation", separation}}, kWidth, kHeight);
  };
  // Farther apart than anything: one aggregate for each pixel that shows something.
  const TechniqueRun one = run(1e6), some = run(300), all = run(0.01);
  expect_valid(one, 1);
  EXPECT_LT(one.executions(), some.executions());
  EXPECT_LT(some.executions(), all.executions());
}

TEST(Agaa, SkyAloneIsNotShaded) {
  expect_plain_sky("agaa", {});
  expect_plain_sky("agaa", {{"samples", 32}, {"aggregates", 4}, {"ndf", "sggx"}});
}

TEST(Agaa, SameBitsFromAnyNumberOfThreads) {
  expect_same_on_all_threads("agaa", {{"storage", "float"}, {"ndf", "sggx"}, {"aggregates", 3}});
  expect_same_on_all_threads("agaa", {{"ndf", "lean"}, {"shadow", "samples"}, {"light_variance", true}});
}

TEST(Agaa, RefusesWhatItCannotDo) {
  for (const ParameterValues& wrong :
       {ParameterValues{{"aggregates", 0}}, ParameterValues{{"aggregates", 5}}, ParameterValues{{"samples", 64}},
        ParameterValues{{"length", 0}}, ParameterValues{{"separation", -1}}, ParameterValues{{"ndf", "beckmann"}},
        ParameterValues{{"shadow", "none"}}, ParameterValues{{"storage", "half"}}, ParameterValues{{"shadow_taps", 3}}})
    expect_refused("agaa", wrong);
}

TEST(Agaa, EmissionAddsUpOverTheSky) {
  // A coloured emitter with slanted edges in front of a sky: linear in coverage, in fixed point and in floats.
  capture::Capture capture = flat_capture(21, 17);
  capture.frames[0].sky = {0.5f, 0.25f, 0.125f};
  capture.frames[0].ambient = {0, 0, 0};
  add_triangles(capture, {-0.8f, -0.9f, 0, 0.9f, -0.3f, 0, -0.1f, 0.8f, 0}, add_emitter(capture, {40, 3, 0.2f}));
  add_triangles(capture, {0.1f, -0.9f, 0.2f, 0.9f, -0.9f, 0.2f, 0.8f, 0.9f, 0.2f}, add_emitter(capture, {0, 1, 1000}));
  for (const int samples : {8, 32}) {
    // `forward` keeps emission in floats.
    const TechniqueRun forward = run_technique(capture, "forward", {{"samples", samples}}, 21, 17);
    for (const char* storage : {"fixed", "float"}) {
      const TechniqueRun run = run_technique(capture, "agaa", {{"samples", samples}, {"storage", storage}}, 21, 17);
      for (std::size_t i = 0; i < run.radiance.size(); ++i)
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(run.radiance[i][c], forward.radiance[i][c], 1e-5f * forward.radiance[i][c] + 5e-4f)
              << "pixel " << i;
    }
  }
}

TEST(Agaa, CoplanarDuplicatesCountOnce) {
  capture::Capture one = flat_capture(19, 13);
  const auto emitter = add_emitter(one, {1, 2, 3});
  add_triangles(one, rectangle(-0.7f, -0.6f, 0.8f, 0.7f, 0), emitter);
  capture::Capture two = one;
  add_triangles(two, rectangle(-0.7f, -0.6f, 0.8f, 0.7f, 0), add_emitter(two, {3, 2, 1}));
  for (const int samples : {8, 32}) {
    const ParameterValues given{{"samples", samples}, {"storage", "float"}};
    const TechniqueRun run = run_technique(one, "agaa", given, 19, 13);
    EXPECT_TRUE(run == run_technique(two, "agaa", given, 19, 13));
    EXPECT_GT(run.executions(), 0);
  }
}

// A camera at the origin that looks along -z with a right angle of view, near plane at 1e-2.
capture::Capture deep_capture(std::uint32_t width, std::uint32_t height) {
  capture::Capture capture = flat_capture(width, height);
  capture.frames[0].projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0, 0, 0.01f, 0};
  return capture;
}

TEST(Agaa, DepthsFromACentimetreTo100Kilometres) {
  capture::Capture capture = deep_capture(31, 23);
  capture.frames[0].ambient = {0, 0, 0};
  add_triangles(capture, {-1e5f, -2e5f, -1e5f, 3e5f, 0.1e5f, -1e5f, -1e5f, 2e5f, -1e5f},
                add_emitter(capture, {1, 0, 0}));
  add_triangles(capture, {-0.02f, -0.03f, -0.02f, 0.005f, -0.02f, -0.02f, -0.004f, 0.03f, -0.02f},
                add_emitter(capture, {0, 1, 0}));
  add_triangles(capture, {-20, 3, -40, 30, 5, -50, 2, 20, -30}, add_emitter(capture, {0, 0, 1}));
  for (const int samples : {8, 32}) {
    const TechniqueRun msaa = run_technique(capture, "msaa", {{"samples", samples}}, 31, 23);
    for (const int aggregates : {1, 2, 4}) {
      const TechniqueRun run =
          run_technique(capture, "agaa", {{"samples", samples}, {"aggregates", aggregates}}, 31, 23);
      expect_valid(run, static_cast<std::uint32_t>(aggregates));
      float most = 0;
      for (std::size_t i = 0; i < run.radiance.size(); ++i) {
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(run.radiance[i][c], msaa.radiance[i][c], 1e-3f) << "pixel " << i;
        most = std::max(most, run.radiance[i].w);
      }
      // Surfaces this far apart never share an aggregate while there is another.
      EXPECT_EQ(most, static_cast<float>(std::min(aggregates, 3)));
    }
  }
}

TEST(Agaa, ShadowOfAFootprintIsThatOfItsSamples) {
  // A floor half in shadow, seen so flat that a pixel's samples spread over the shadow's edge: with one tap the edge is
  // where the mean lies, with more it has the width of the footprint.
  const capture::Capture city = capture::generate("city", {1, 96, 54, 1, 1});
  const TechniqueRun msaa = run_technique(city, "msaa", {{"samples", 8}}, 96, 54);
  const auto error = [&](int taps) {
    const TechniqueRun run = run_technique(city, "agaa", {{"shadow_taps", taps}}, 96, 54);
    expect_valid(run, 2);
    return mean_squared_difference(run, msaa);
  };
  const double one = error(1), four = error(4), eight = error(8);
  EXPECT_LT(four, one);
  EXPECT_LT(eight, 1.02 * four);
}

TEST(Agaa, ShadowsOfSamplesAreNearerBruteForceWhereColoursChangeWithThem) {
  // Section 6: sunlit leaves before a red wall in shadow share an aggregate.
  const capture::Capture leaves = capture::generate("agaa_correlation", {1, 96, 54, 1, 1});
  const TechniqueRun msaa = run_technique(leaves, "msaa", {{"samples", 8}}, 96, 54);
  const auto error = [&](const char* shadow) {
    const TechniqueRun run = run_technique(leaves, "agaa", {{"aggregates", 1}, {"shadow", shadow}}, 96, 54);
    expect_valid(run, 1);
    return mean_squared_difference(run, msaa);
  };
  EXPECT_LT(error("samples"), 0.3 * error("footprint"));
}

TEST(Agaa, AlphaIsDecidedByVisibilityAlone) {
  const capture::Capture foliage = capture::generate("foliage", {1, kWidth, kHeight, 1, 0.05});
  for (const char* alpha : {"to_coverage", "test", "per_sample"}) {
    const ParameterValues given{{"alpha", alpha}};
    const TechniqueRun run = run_technique(foliage, "agaa", given, kWidth, kHeight);
    EXPECT_TRUE(run == run_technique(foliage, "agaa", given, kWidth, kHeight)) << alpha;
    const TechniqueRun msaa = run_technique(foliage, "msaa", given, kWidth, kHeight);
    for (std::size_t i = 0; i < run.radiance.size(); ++i)
      ASSERT_EQ(run.radiance[i].w == 0, msaa.radiance[i].w == 0) << alpha << ", pixel " << i;
    EXPECT_LT(mean_squared_difference(run, msaa), 1e-3) << alpha;
  }
}

}  // namespace
}  // namespace subpixel::replay
