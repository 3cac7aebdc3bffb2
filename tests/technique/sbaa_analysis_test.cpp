// The analysis on the device against the algorithm written anew for the host, on random pixels: exact agreement.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/tests/test_interface.h"
#include "tests/technique/pixel_generator.hpp"
#include "tests/technique/sbaa_transcription.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

using namespace sbaa_transcription;

// A pixel of a few triangles, or one where most samples show a triangle that has nothing to do with the others.
std::vector<Sample> pixel_of(PixelGenerator& generator, std::uint32_t samples, double angle) {
  std::vector<Sample> pixel;
  for (const bool busy = generator.whole(4) == 0; pixel.size() < samples;) {
    const std::vector<RandomSample> made = generator.pixel(samples, angle);
    const std::size_t end = busy ? pixel.size() + 1 + generator.whole(2) : samples;
    for (std::size_t s = pixel.size(); s < std::min<std::size_t>(end, samples); ++s) {
      const RandomTriangle* const t = made[s].triangle;
      pixel.push_back({t ? t->normal : glm::vec3(0), made[s].depth,
                       t ? std::fabs(t->slopes.x) + std::fabs(t->slopes.y) : 0.0f, made[s].number()});
    }
  }
  return pixel;
}

void expect_agreement(std::uint32_t samples, std::uint32_t count, Options options) {
  gpu::PassRecorder recorder(test_device());
  gpu::Buffer& in = recorder.buffer("samples", std::uint64_t{count} * samples * sizeof(Sample));
  gpu::Buffer& out = recorder.buffer("masks", std::uint64_t{count} * 8 * 4);
  PixelGenerator generator(samples + 100 * options.keep);
  std::vector<std::vector<std::uint32_t>> expected;
  std::uint32_t merged = 0, dropped = 0, collided = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::vector<Sample> given = pixel_of(generator, samples, options.angle);
    std::copy(given.begin(), given.end(), in.as<Sample>().begin() + std::size_t{i} * samples);
    expected.push_back(analyse(given, options));
    // What the pixels must contain for the comparison to mean something.
    std::uint32_t covered = 0, kept = 0;
    bool one_has_two = false;
    std::map<std::uint32_t, std::uint32_t> number_of_hash;
    for (std::uint32_t s = 0; s < samples; ++s) {
      if (given[s].triangle == SUBPIXEL_NO_TRIANGLE) continue;
      covered |= 1u << s;
      const auto [found, fresh] = number_of_hash.emplace(hash(given[s].triangle), given[s].triangle);
      if (!fresh && found->second != given[s].triangle) ++collided;
    }
    for (const auto mask : expected.back()) {
      kept |= mask;
      std::uint32_t first = samples;
      for (std::uint32_t s = 0; s < samples; ++s) {
        if ((mask >> s & 1) == 0) continue;
        if (first == samples) first = s;
        one_has_two = one_has_two || hash(given[s].triangle) != hash(given[first].triangle);
      }
    }
    merged += one_has_two ? 1 : 0;
    dropped += kept != covered ? 1 : 0;
  }
  EXPECT_GT(collided, count / 1000);
  EXPECT_TRUE(!options.merge || merged > count / 50) << merged;
  EXPECT_TRUE(options.keep >= samples || dropped > count / 500) << dropped;

  gpu::ComputePass pass;
  pass.name = "analyse";
  pass.shader = "tests/analyse_pixels.comp";
  pass.constants = {{CONSTANT_SAMPLES, samples}};
  pass.bindings = {gpu::reads(TEST_SLOT_SAMPLES, in), gpu::writes(TEST_SLOT_MASKS, out)};
  const gpu_types::AnalyseTestPush push{count, options.keep, options.merge ? 1u : 0u, options.cosine()};
  pass.push = gpu::PushConstants(push);
  pass.groups = {(count + 63) / 64, 1, 1};
  recorder.compute(std::move(pass));
  recorder.run();
  std::uint32_t differences = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto masks = out.as<std::uint32_t>().subspan(std::size_t{i} * 8, 8);
    differences += std::equal(masks.begin(), masks.end(), expected[i].begin()) ? 0 : 1;
  }
  EXPECT_EQ(differences, 0u) << samples << " samples, " << options.keep << " kept";
}

TEST(SbaaAnalysis, AgreesWithTheHost) {
  expect_agreement(8, 100'000, {});
}

TEST(SbaaAnalysis, AgreesWithoutMerging) {
  expect_agreement(8, 100'000, {.merge = false});
}

TEST(SbaaAnalysis, AgreesForEveryNumberOfSurfaces) {
  for (const std::uint32_t keep : {1u, 2u, 3u, 5u, 6u, 7u, 8u}) {
    expect_agreement(8, 20'000, {.keep = keep});
    expect_agreement(8, 20'000, {.merge = false, .keep = keep});
  }
}

TEST(SbaaAnalysis, AgreesForOtherAngles) {
  for (const double angle : {0.0, 0.2, 1.5, 3.14}) expect_agreement(8, 20'000, {.angle = angle});
}

TEST(SbaaAnalysis, AgreesAtOtherSampleCounts) {
  expect_agreement(4, 100'000, {});
  expect_agreement(16, 40'000, {});
  expect_agreement(32, 20'000, {});
  expect_agreement(32, 20'000, {.merge = false, .keep = 8});
}

}  // namespace
}  // namespace subpixel::replay
