// The classification on the device against the rule written anew for the host, on random pixels: exact agreement.
#include <gtest/gtest.h>

#include <cmath>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/tests/test_interface.h"
#include "tests/technique/pixel_generator.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

using Sample = gpu_types::ClassifiedTestSample;

struct Thresholds {
  float depth_scale = 1, least_cosine = 0.99f;
};

// TECHNIQUE: "complex when, against sample 0, a depth differs by more than |dz/dx| + |dz/dy|, or n0.n < 0.99, or a
// material differs", or only one of the two shows anything. Samples of one triangle have one plane, normal and
// material.
bool complex(const std::vector<Sample>& pixel, glm::vec2 slopes, Thresholds thresholds) {
  const Sample& zero = pixel[0];
  for (const Sample& s : pixel) {
    if (s.triangle == zero.triangle) continue;
    if (s.triangle == SUBPIXEL_NO_TRIANGLE || zero.triangle == SUBPIXEL_NO_TRIANGLE) return true;
    if (std::fabs(s.depth - zero.depth) > (std::fabs(slopes.x) + std::fabs(slopes.y)) * thresholds.depth_scale)
      return true;
    float cosine = zero.normal.x * s.normal.x;
    cosine = cosine + zero.normal.y * s.normal.y;
    cosine = cosine + zero.normal.z * s.normal.z;
    if (cosine < thresholds.least_cosine || s.material != zero.material) return true;
  }
  return false;
}

// Pixels that differ between device and host, of `count`; all of one kind fail the test.
void expect_agreement(std::uint32_t samples, std::uint32_t count, Thresholds thresholds) {
  gpu::PassRecorder recorder(test_device());
  gpu::Buffer& in = recorder.buffer("samples", std::uint64_t{count} * samples * sizeof(Sample));
  gpu::Buffer& slopes = recorder.buffer("slopes", std::uint64_t{count} * sizeof(glm::vec2));
  gpu::Buffer& out = recorder.buffer("complex", std::uint64_t{count} * 4);
  PixelGenerator generator(samples);
  std::vector<bool> expected(count);
  std::uint32_t complex_count = 0, one_triangle = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto pixel = generator.pixel(samples, std::acos(0.99));
    std::vector<Sample> given;
    bool same = true;
    for (const RandomSample& s : pixel) {
      given.push_back(
          {s.triangle ? s.triangle->normal : glm::vec3(0), s.depth, s.number(), s.triangle ? s.triangle->material : 0});
      same = same && s.number() == pixel[0].number();
    }
    std::copy(given.begin(), given.end(), in.as<Sample>().begin() + std::size_t{i} * samples);
    slopes.as<glm::vec2>()[i] = pixel[0].triangle ? pixel[0].triangle->slopes : glm::vec2(0);
    expected[i] = complex(given, slopes.as<glm::vec2>()[i], thresholds);
    complex_count += expected[i] ? 1 : 0;
    one_triangle += same ? 1 : 0;
  }
  // The pixels must not all be of one kind, nor be simple only because one triangle covers them.
  EXPECT_GT(complex_count, count / 10);
  EXPECT_GT(count - complex_count, one_triangle + count / 100);

  gpu::ComputePass pass;
  pass.name = "classify";
  pass.shader = "tests/classify_pixels.comp";
  pass.constants = {{CONSTANT_SAMPLES, samples}};
  pass.bindings = {gpu::reads(TEST_SLOT_SAMPLES, in), gpu::reads(TEST_SLOT_SLOPES, slopes),
                   gpu::writes(TEST_SLOT_COMPLEX, out)};
  const gpu_types::ClassifyTestPush push{count, thresholds.depth_scale, thresholds.least_cosine};
  pass.push = gpu::PushConstants(push);
  pass.groups = {(count + 63) / 64, 1, 1};
  recorder.compute(std::move(pass));
  recorder.run();
  std::uint32_t differences = 0;
  for (std::uint32_t i = 0; i < count; ++i) differences += (out.as<std::uint32_t>()[i] != 0) != expected[i] ? 1 : 0;
  EXPECT_EQ(differences, 0u) << samples << " samples";
}

TEST(SimpleComplexClassification, AgreesWithTheHost) {
  expect_agreement(8, 100'000, {});
}

TEST(SimpleComplexClassification, AgreesAtOtherSampleCounts) {
  expect_agreement(4, 100'000, {});
  expect_agreement(16, 40'000, {});
  expect_agreement(32, 20'000, {});
}

TEST(SimpleComplexClassification, AgreesWithOtherThresholds) {
  expect_agreement(8, 20'000, {0.25f, 0.99f});
  expect_agreement(8, 20'000, {3.0f, 0.9f});
  expect_agreement(8, 20'000, {1000.0f, -1.0f});
}

}  // namespace
}  // namespace subpixel::replay
