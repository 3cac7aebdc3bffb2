// Every technique of the registry on every hard case.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>

#include <numeric>

#include "replay/frame/run_frame.hpp"
#include "replay/measure/error_bounds.hpp"
#include "replay/measure/metrics.hpp"
#include "replay/reference/reference_cache.hpp"
#include "replay/techniques/registry.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kReferenceSamples = 64;

// Shared by the processes that run the tests, which come to the same keys for the same scenes.
std::filesystem::path reference_folder() {
  return std::filesystem::path(SUBPIXEL_BINARY).parent_path() / "hard_case_references";
}

ReferenceImage reference_of(FrameScene& scene) {
  return cached_reference(test_device(), scene.scene, scene.frame(), {.samples = kReferenceSamples},
                          ReferenceCache(reference_folder()))
      .image;
}

ErrorBounds error_bounds() {
  return ErrorBounds(SUBPIXEL_SOURCE_DIR "/tests/hard_cases/bounds.json");
}

const capture::HardCase& find_case(std::string_view name) {
  for (const capture::HardCase& hard : capture::hard_cases())
    if (hard.name == name) return hard;
  throw std::logic_error("no such case");
}

class HardCases : public testing::TestWithParam<const Technique*> {
 protected:
  const Technique& technique() const { return *GetParam(); }
  FrameRun run(FrameScene& scene, const ParameterValues& given = {}) const {
    return run_frame(scene, technique().with(given));
  }
  bool single_sample() const {
    return technique().name == "noaa" || technique().name == "fxaa" || technique().name == "smaa";
  }
};

// No pixel is NaN, infinite or negative; no pixel is lit more often than it has samples.
void expect_sound(const FrameRun& result, std::string_view name) {
  EXPECT_EQ(invalid_pixels(result.radiance), 0u) << name;
  EXPECT_EQ(invalid_pixels(result.display), 0u) << name;
  for (const float value : result.display.pixels) ASSERT_LE(value, 1.0f) << name;
  for (const float value : result.radiance.pixels) ASSERT_LE(value, 60000.0f) << name;
  for (std::size_t i = 0; i < result.executions.size(); ++i) {
    const float executions = result.executions[i];
    ASSERT_EQ(executions, std::floor(executions)) << name << " pixel " << i;
    ASSERT_TRUE(executions >= 0 && executions <= static_cast<float>(result.samples)) << name << " pixel " << i;
  }
}

TEST_P(HardCases, StayWithinTheirBounds) {
  const ErrorBounds bounds = error_bounds();
  for (const capture::HardCase& hard : capture::hard_cases()) {
    ASSERT_TRUE(bounds.has(hard.name)) << hard.name << " lacks a row in bounds.json";
    FrameScene scene(test_device(), capture::make_case(hard));
    const FrameRun result = run(scene);
    expect_sound(result, hard.name);
    const double error = mse(reference_of(scene).display, result.display);
    const ErrorBound bound = bounds.of(hard.name, technique().name);
    EXPECT_LE(error, bound.mse) << hard.name << ": " << bound.why;
    RecordProperty(std::string(hard.name), std::to_string(error));
    const double executions = std::accumulate(result.executions.begin(), result.executions.end(), 0.0);
    EXPECT_EQ(executions > 0, hard.name != "empty") << hard.name;
  }
}

// The fewest and the most samples, and the least of every other number: one surface, the smallest pool, angle 0.
TEST_P(HardCases, ExtremeParametersStaySound) {
  for (const std::string_view name : {"hard_overflow", "hard_opposite_normals"}) {
    FrameScene scene(test_device(), find_case(name).make({.frames = 1, .width = 24, .height = 18}));
    for (const Parameter& p : technique().parameters) {
      if (p.kind != ParameterKind::integer && p.kind != ParameterKind::number) continue;
      std::vector<double> values{p.minimum};
      if (p.name == "samples") values = {p.allowed.front(), p.allowed.back()};
      for (const double value : values) {
        if (p.default_value.is_number() && p.default_value.get<double>() == value) continue;
        const nlohmann::json given =
            p.kind == ParameterKind::integer ? nlohmann::json(static_cast<int>(value)) : nlohmann::json(value);
        expect_sound(run(scene, {{std::string(p.name), given}}), fmt::format("{}, {} = {}", name, p.name, value));
      }
    }
  }
}

TEST_P(HardCases, AnEmptyFrameIsTheSky) {
  FrameScene scene(test_device(), capture::make_case(find_case("empty")));
  const FrameRun result = run(scene);
  const auto& sky = scene.capture.frames[0].sky;
  for (std::size_t i = 0; i < result.radiance.pixels.size(); ++i)
    ASSERT_NEAR(result.radiance.pixels[i], sky[i % 3], 1e-6f);
  for (const float executions : result.executions) ASSERT_EQ(executions, 0);
}

TEST_P(HardCases, OneTriangleFillsTheScreen) {
  FrameScene scene(test_device(), capture::make_case(find_case("hard_fullscreen")));
  const FrameRun result = run(scene);
  const float colour[] = {0.5f, 0.25f, 1};
  for (std::size_t i = 0; i < result.radiance.pixels.size(); ++i)
    ASSERT_NEAR(result.radiance.pixels[i], colour[i % 3], 1e-6f) << "pixel " << i / 3;
  for (const float executions : result.executions) ASSERT_GE(executions, 1);
}

// Inside is what the reference shows without a trace of the other side, a pixel from the border.
template <typename Inside>
std::vector<std::size_t> pixels_inside(const Image& image, const Inside& inside) {
  std::vector<std::size_t> pixels;
  for (std::uint32_t y = 1; y + 1 < image.height; ++y) {
    for (std::uint32_t x = 1; x + 1 < image.width; ++x) {
      bool all = true;
      for (std::uint32_t k = 0; k < 9; ++k)
        all = all && inside(&image.pixels[image.offset(x + k % 3 - 1, y + k / 3 - 1)]);
      if (all) pixels.push_back(image.offset(x, y));
    }
  }
  return pixels;
}

TEST_P(HardCases, MeshesAreClosed) {
  FrameScene scene(test_device(), capture::make_case(find_case("hard_shared_edges")));
  const ReferenceImage reference = reference_of(scene);
  const FrameRun result = run(scene);
  const auto white = pixels_inside(reference.linear, [](const float* p) { return p[0] == 1; });
  const auto black = pixels_inside(reference.linear, [](const float* p) { return p[0] == 0; });
  EXPECT_GT(white.size(), 500u);
  EXPECT_GT(black.size(), 500u);
  for (const std::size_t at : white) ASSERT_NEAR(result.radiance.pixels[at], 1, 1e-6) << "pixel " << at / 3;
  for (const std::size_t at : black) ASSERT_EQ(result.radiance.pixels[at], 0) << "pixel " << at / 3;
}

TEST_P(HardCases, JunctionsLeakSingleSamples) {
  FrameScene scene(test_device(), capture::make_case(find_case("hard_t_junctions")));
  const ReferenceImage reference = reference_of(scene);
  const FrameRun result = run(scene);
  const auto wall = pixels_inside(reference.linear, [](const float* p) { return p[0] < 0.3f; });
  EXPECT_GT(wall.size(), 800u);
  std::size_t leaks = 0;
  for (const std::size_t at : wall) {
    const float value = result.radiance.pixels[at];
    ASSERT_GE(value, 0.25f - 1e-6f) << "pixel " << at / 3;
    // White sky through one sample, or through a sixteenth of a pixel where samples are finer.
    const float leak = std::max(1.0f / 16, 1 / static_cast<float>(result.samples));
    ASSERT_LE(value, 0.25f + 0.75f * leak + 1e-6f) << "pixel " << at / 3;
    leaks += value > 0.25f + 1e-6f ? 1 : 0;
  }
  // Finer samples meet more of the cracks, which are a snapping step wide.
  EXPECT_LE(leaks, result.samples <= 8 ? 4u : 16u);
}

TEST_P(HardCases, BadTrianglesAreNotThere) {
  capture::Capture capture = capture::make_case(find_case("hard_bad_vertices"));
  FrameScene with(test_device(), capture);
  ASSERT_EQ(capture.frames[0].draws.at(1).name, "bad");
  capture.frames[0].draws.pop_back();
  FrameScene without(test_device(), capture);
  EXPECT_EQ(run(with).radiance.pixels, run(without).radiance.pixels);
}

TEST_P(HardCases, TheFirstOfEqualDepthsStays) {
  if (technique().name == "dcaa" || technique().name == "hybrid")
    GTEST_SKIP() << "it has no depth test: masks may overlap, and both merge";
  capture::Capture capture = capture::make_case(find_case("hard_coplanar"));
  FrameScene twice(test_device(), capture);
  ASSERT_EQ(capture.frames[0].draws.at(1).name, "second");
  capture.frames[0].draws.erase(capture.frames[0].draws.begin() + 1);
  FrameScene once(test_device(), capture);
  const Image a = run(twice).radiance, b = run(once).radiance;
  // The right half, where the other two fight, has no duplicates.
  std::size_t changed = 0;
  for (std::uint32_t y = 0; y < a.height; ++y) {
    for (std::uint32_t x = 0; x < a.width / 2; ++x) {
      bool same = true;
      for (std::uint32_t c = 0; c < 3; ++c)
        same = same && std::abs(a.pixels[a.offset(x, y) + c] - b.pixels[a.offset(x, y) + c]) < 1e-4f;
      changed += same ? 0 : 1;
    }
  }
  EXPECT_EQ(changed, 0u);
}

// What is a million units away shows as if it were near, but for the rounding of positions that lights are seen from.
TEST_P(HardCases, FarFromTheOriginNothingMoves) {
  capture::Capture capture = capture::make_case(find_case("hard_far_origin"));
  FrameScene far(test_device(), capture);
  capture::Frame& frame = capture.frames[0];
  const auto by = static_cast<float>(capture::kFarOrigin);
  for (capture::Draw& draw : frame.draws) draw.transform[12] -= by;
  for (capture::PointLight& light : frame.point_lights) light.position[0] -= by;
  frame.view[12] += by;
  FrameScene near(test_device(), capture);
  const FrameRun a = run(far), b = run(near);
  EXPECT_EQ(a.executions, b.executions);
  const double difference = mse(a.display, b.display);
  RecordProperty("mse", std::to_string(difference));
  EXPECT_LT(difference, 1e-3);
}

TEST_P(HardCases, BlackStaysBlackBesideALight) {
  FrameScene scene(test_device(), capture::make_case(find_case("hard_bright_light")));
  const ReferenceImage reference = reference_of(scene);
  const FrameRun result = run(scene);
  // The wall sends some 10,000; what reflects nothing but at grazing angles sends less than a hundredth of that.
  const auto black = pixels_inside(reference.linear, [](const float* p) { return p[0] < 100; });
  EXPECT_GT(black.size(), 500u);
  for (const std::size_t at : black) {
    // Where it touches the wall, which lies in its plane, techniques that merge may take both for one surface.
    if (at / 3 % reference.linear.width < 42) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const float expected = reference.linear.pixels[at + c];
      ASSERT_NEAR(result.radiance.pixels[at + c], expected, 0.05f * expected + 1e-3f) << "pixel " << at / 3;
    }
  }
  EXPECT_GT(*std::max_element(result.radiance.pixels.begin(), result.radiance.pixels.end()), 1000.0f);
}

TEST_P(HardCases, EmittersShowTheirOwnRadiance) {
  FrameScene scene(test_device(), capture::make_case(find_case("hard_emissive_only")));
  const ReferenceImage reference = reference_of(scene);
  const FrameRun result = run(scene);
  for (const auto& material : scene.capture.materials) {
    const auto& radiance = material.emissive;
    const auto lamp =
        pixels_inside(reference.linear, [&](const float* p) { return std::abs(p[0] / radiance[0] - 1) < 1e-4f; });
    EXPECT_GT(lamp.size(), 10u) << material.name;
    // 9 bits of mantissa beside the brightest channel. `agaa` adds emission in fixed point: 22 bits of the brightest
    // emitter, 1e4, so the faintest ones drown.
    const float tolerance = 0.003f * radiance[0] + (technique().name == "agaa" ? 0.02f : 0.0f);
    for (const std::size_t at : lamp)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(result.radiance.pixels[at + c], radiance[c], tolerance) << material.name;
  }
}

TEST_P(HardCases, OppositeNormalsGiveHalfTheLight) {
  if (single_sample()) GTEST_SKIP() << "one sample sees one strip";
  FrameScene scene(test_device(), capture::make_case(find_case("hard_opposite_normals")));
  const ReferenceImage reference = reference_of(scene);
  const FrameRun result = run(scene);
  const auto strips = pixels_inside(reference.linear, [&](const float* p) { return std::abs(p[2] / p[0] - 1) < 0.2f; });
  ASSERT_GT(strips.size(), 300u);
  double shown = 0, wanted = 0;
  for (const std::size_t at : strips) {
    shown += static_cast<double>(result.radiance.pixels[at]);
    wanted += static_cast<double>(reference.linear.pixels[at]);
  }
  RecordProperty("ratio", std::to_string(shown / wanted));
  // Where normals cancel or one strip stands for all, the table says so: between nothing and twice the light.
  const bool resolves = error_bounds().of("hard_opposite_normals", technique().name).mse < 1e-3;
  EXPECT_NEAR(shown / wanted, 1, resolves ? 0.1 : 1.0);
}

INSTANTIATE_TEST_SUITE_P(All, HardCases,
                         testing::ValuesIn(std::vector<const Technique*>(techniques().begin(), techniques().end())),
                         [](const auto& technique) { return std::string(technique.param->name); });

}  // namespace
}  // namespace subpixel::replay
