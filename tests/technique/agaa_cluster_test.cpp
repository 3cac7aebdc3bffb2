// The clustering on the device against algorithm 1 of the paper written anew for the host, on random pixels: the same
// aggregates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <utility>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/tests/agaa_test_interface.h"
#include "tests/technique/agaa_transcription.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

using namespace agaa_transcription;

// Samples of a few surfaces whose positions and normals lie as near each other as equation 1 tells apart.
class Pixels {
 public:
  explicit Pixels(std::uint64_t seed) : random_(seed) {}

  std::vector<Given> pixel(std::size_t count) {
    std::vector<Given> surfaces(1 + whole(6));
    const float spread = std::exp2(4.0f * unit() - 2.0f), origin = 200.0f * unit();
    for (auto& s : surfaces)
      s = {glm::vec3(0, 0, origin) + spread * glm::vec3(unit(), unit(), unit()), direction(whole(3) == 0)};
    std::vector<Given> samples(count);
    for (auto& s : samples) {
      s = surfaces[whole(static_cast<std::uint32_t>(surfaces.size()))];
      if (whole(3) != 0) s.position += 0.1f * spread * glm::vec3(unit(), unit(), unit());
    }
    return samples;
  }
  // At least one; often few.
  std::uint32_t covered(std::size_t count) {
    std::uint32_t mask = static_cast<std::uint32_t>(random_());
    if (whole(2) == 0) mask |= static_cast<std::uint32_t>(random_());
    if (whole(4) == 0) mask = ~0u;
    if (whole(8) == 0) mask &= static_cast<std::uint32_t>(random_());
    const std::uint32_t all = count == 32 ? ~0u : (1u << count) - 1;
    return (mask & all) != 0 ? mask & all : 1u << whole(static_cast<std::uint32_t>(count));
  }
  float unit() { return static_cast<float>(random_() >> 40) * 0x1p-24f; }
  std::uint32_t whole(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }

 private:
  glm::vec3 direction(bool anywhere) {
    const float z = anywhere ? 2 * unit() - 1 : 0.5f + 0.5f * unit(), turn = 6.2831853f * unit();
    const float r = std::sqrt(std::max(1 - z * z, 0.0f));
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  std::mt19937_64 random_;
};

struct Totals {
  std::size_t several = 0, full = 0;
};

// Pixels that the device clusters otherwise than the host fail the test.
Totals expect_same_aggregates(const std::vector<std::vector<Given>>& pixels, const std::vector<std::uint32_t>& covered,
                              std::uint32_t aggregates, float separation) {
  const auto count = static_cast<std::uint32_t>(pixels.size()), n = static_cast<std::uint32_t>(pixels[0].size());
  gpu::PassRecorder recorder(test_device());
  gpu::Buffer& in = recorder.buffer("samples", std::uint64_t{count} * n * sizeof(Given));
  gpu::Buffer& masks = recorder.buffer("covered", std::uint64_t{count} * 4);
  gpu::Buffer& out = recorder.buffer("results", std::uint64_t{count} * sizeof(glm::uvec3));
  for (std::size_t i = 0; i < count; ++i) {
    std::copy(pixels[i].begin(), pixels[i].end(), in.as<Given>().begin() + i * n);
    masks.as<std::uint32_t>()[i] = covered[i];
  }
  gpu::ComputePass pass;
  pass.name = "cluster";
  pass.shader = "tests/agaa_cluster.comp";
  pass.constants = {{CONSTANT_SAMPLES, n}, {AGAA_CONSTANT_AGGREGATES, aggregates}};
  pass.bindings = {gpu::reads(AGAA_TEST_SLOT_SAMPLES, in), gpu::reads(AGAA_TEST_SLOT_COVERED, masks),
                   gpu::writes(AGAA_TEST_SLOT_RESULTS, out)};
  pass.push = gpu::PushConstants(gpu_types::AgaaTestClusterPush{count, separation});
  pass.groups = {(count + 63) / 64, 1, 1};
  recorder.compute(std::move(pass));
  recorder.run();
  Totals totals;
  std::uint32_t wrong = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Aggregates expected = paper_aggregates(pixels[i], covered[i], aggregates, separation);
    const glm::uvec3 got = out.as<glm::uvec3>()[i];
    bool same = got.z == expected.count;
    for (std::uint32_t s = 0; s < n; ++s) {
      const std::uint32_t of = (got.x >> s & 1u) | (got.y >> s & 1u) << 1;
      same = same && of == expected.of[s].value_or(0);
    }
    if (!same && ++wrong == 1) ADD_FAILURE() << "first difference: pixel " << i;
    totals.several += expected.count > 1;
    totals.full += expected.count == aggregates;
  }
  EXPECT_EQ(wrong, 0u) << n << " samples, " << aggregates << " aggregates";
  return totals;
}

Totals expect_same_on_random_pixels(std::uint32_t n, std::uint32_t aggregates, std::uint32_t count, float separation,
                                    std::uint64_t seed) {
  Pixels random(seed);
  std::vector<std::vector<Given>> pixels(count);
  std::vector<std::uint32_t> covered(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    pixels[i] = random.pixel(n);
    covered[i] = random.covered(n);
  }
  return expect_same_aggregates(pixels, covered, aggregates, separation);
}

TEST(AgaaCluster, FindsTheAggregatesOfThePaperOn100000Pixels) {
  const Totals totals = expect_same_on_random_pixels(8, 2, 40'000, 0.01f, 1);
  EXPECT_GT(totals.several, 20'000u);
  EXPECT_LT(totals.several, 38'000u);
  expect_same_on_random_pixels(4, 2, 20'000, 0.01f, 2);
  expect_same_on_random_pixels(16, 2, 20'000, 0.01f, 3);
  expect_same_on_random_pixels(32, 2, 20'000, 0.01f, 4);
}

TEST(AgaaCluster, FindsThemForEveryNumberOfAggregatesAndAnySeparation) {
  std::uint64_t seed = 10;
  const std::pair<std::uint32_t, std::uint32_t> cases[] = {{4, 4}, {8, 1}, {8, 3}, {8, 4}, {16, 3}, {32, 4}};
  for (const auto& [n, aggregates] : cases) {
    const Totals apart = expect_same_on_random_pixels(n, aggregates, 2000, 1.0f, ++seed);
    const Totals any = expect_same_on_random_pixels(n, aggregates, 2000, 0.0f, seed);
    if (aggregates > 1) {
      EXPECT_LT(apart.full, any.full);
    }
  }
}

TEST(AgaaCluster, NumericalCases) {
  const glm::vec3 up(0, 0, 1);
  std::vector<std::vector<Given>> pixels;
  // Opposite normals at one place, whose mean has no direction; one place and normal; distances near and far; the far
  // end of a depth range of 1e-2 to 1e5, in tenths of a world unit; a sample that can't be placed at all.
  pixels.push_back({{up, up}, {up, -up}, {up, up}, {up, -up}});
  pixels.push_back({{up, up}, {up, up}, {up, up}, {up, up}});
  pixels.push_back({{up * 0.1f, up}, {up * 1e6f, up}, {up * 0.1f, up}, {up * 1e6f, up}});
  pixels.push_back({{up * 1e6f, up}, {up * 1e6f, -up}, {up * 1.000001e6f, up}, {up * 1e6f, up}});
  pixels.push_back({{up * 1e30f, up}, {up, up}, {up, up}, {-up * 1e30f, up}});
  const std::vector<std::uint32_t> all(pixels.size(), 15u);
  for (const std::uint32_t aggregates : {2u, 3u, 4u}) expect_same_aggregates(pixels, all, aggregates, 0.01f);
  // One sample, and none.
  expect_same_aggregates({pixels[0], pixels[0]}, {4u, 0u}, 2, 0.01f);
}

}  // namespace
}  // namespace subpixel::replay
