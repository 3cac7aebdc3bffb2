// The shaders' streaming compression against the transcription from the paper, on streams of random fragments.
#include <gtest/gtest.h>

#include <random>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/include/shared_types.h"
#include "tests/technique/scene_device_fixture.hpp"
#include "tests/technique/streaming_comparison.hpp"

namespace subpixel::streaming_test {
namespace {

using gpu_types::StreamTestFragment;

struct Case {
  Options options;
  bool varying_roughness = false, emissive = false;
  std::uint32_t pixels = 2000;
};

// Streams in which every outcome is frequent: a few features a pixel (a plane, a normal, an albedo) that fragments
// share and leave by small amounts, masks that are parts of the pixel or all of it.
struct Streams {
  std::vector<glm::uvec2> ranges;
  std::vector<StreamTestFragment> fragments;
};

Streams random_streams(const Case& wanted, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return std::uniform_real_distribution<float>(0, 1)(random); };
  const auto below = [&](std::uint32_t n) { return std::uniform_int_distribution<std::uint32_t>(0, n - 1)(random); };
  const auto bits = [&] { return static_cast<std::uint32_t>(random()); };
  const std::uint32_t all = wanted.options.samples == 32 ? ~0u : (1u << wanted.options.samples) - 1;
  Streams streams;
  for (std::uint32_t pixel = 0; pixel < wanted.pixels; ++pixel) {
    const std::uint32_t count = 1 + below(60), features = 1 + below(6);
    struct Feature {
      float distance, slope_x, slope_y;
      Vector normal;
    };
    std::vector<Feature> feature(features);
    for (auto& f : feature)
      f = {1.0f + 8.0f * unit(),
           (unit() - 0.5f) * unit(),
           (unit() - 0.5f) * unit(),
           {unit() - 0.5f, unit() - 0.5f, unit() - 0.5f}};
    streams.ranges.emplace_back(static_cast<std::uint32_t>(streams.fragments.size()), count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Feature& f = feature[below(features)];
      const float distance = f.distance + (unit() - 0.5f) * 0.1f;
      const float tilt = 0.6f * unit();
      std::uint32_t mask = bits() & all;
      if (below(3) != 0) mask &= bits();
      if (below(8) == 0) mask = all;
      if (mask == 0) mask = 1u << below(wanted.options.samples);
      StreamTestFragment fragment{};
      // Reversed depth 1 / distance and its slopes.
      fragment.plane = {1.0f / distance, -f.slope_x / (distance * distance), -f.slope_y / (distance * distance),
                        0.001f};
      fragment.depth = {distance, f.slope_x + (unit() - 0.5f) * 0.01f, f.slope_y, 1.0f};
      fragment.words = {mask, bits(),
                        encode_normal({f.normal.x + tilt * (unit() - 0.5f), f.normal.y + tilt * (unit() - 0.5f),
                                       f.normal.z + tilt * (unit() - 0.5f)}),
                        bits() & 255u};
      // From what is below the smallest exponent to what is above the largest; a quarter emits nothing.
      if (wanted.emissive && below(4) != 0) {
        const float brightest = std::exp2(40 * unit() - 20);
        fragment.more.x = encode_emission({brightest * unit(), brightest * unit(), brightest});
      }
      streams.fragments.push_back(fragment);
    }
  }
  return streams;
}

std::vector<std::uint32_t> run_on_device(const Case& wanted, const WordLayout& layout, const Streams& streams) {
  gpu::Device& device = replay::test_device();
  gpu::PassRecorder recorder(device);
  gpu::Buffer frame(device, "frame", sizeof(gpu_types::FrameConstants));
  gpu::Buffer& ranges = recorder.buffer("ranges", streams.ranges.size() * sizeof(glm::uvec2));
  std::copy(streams.ranges.begin(), streams.ranges.end(), ranges.as<glm::uvec2>().begin());
  gpu::Buffer& fragments = recorder.buffer("fragments", streams.fragments.size() * sizeof(StreamTestFragment));
  std::copy(streams.fragments.begin(), streams.fragments.end(), fragments.as<StreamTestFragment>().begin());
  gpu::Buffer& quads = recorder.buffer("state", streams.ranges.size() * layout.quads() * 16);
  const Options& o = wanted.options;
  const std::uint32_t options =
      (o.merge_normals ? STREAM_MERGE_NORMALS : 0u) | (o.merge_depth ? STREAM_MERGE_DEPTH : 0u) |
      (o.merge_coverage ? STREAM_MERGE_COVERAGE : 0u) | (o.weight_by_coverage ? STREAM_WEIGHT_COVERAGE : 0u) |
      (o.depth_tested ? STREAM_DEPTH_TESTED : 0u) | (o.discard_by_resolved ? STREAM_DISCARD_RESOLVED : 0u);
  const std::uint32_t features = FEATURE_METAL | (wanted.varying_roughness ? FEATURE_VARYING_ROUGHNESS : 0u) |
                                 (wanted.emissive ? FEATURE_EMISSIVE : 0u);
  gpu::ComputePass pass;
  pass.name = "stream";
  pass.shader = "tests/streaming_stream.comp";
  pass.constants = {{CONSTANT_SAMPLES, o.samples},
                    {CONSTANT_FEATURES, features},
                    {STREAM_CONSTANT_SURFACES, o.surfaces},
                    {STREAM_CONSTANT_COS_NORMAL_ANGLE, std::bit_cast<std::uint32_t>(o.cos_normal_angle)},
                    {STREAM_CONSTANT_OPTIONS, options}};
  pass.bindings = {gpu::uniform(frame), gpu::reads(STREAM_TEST_SLOT_RANGES, ranges),
                   gpu::reads(STREAM_TEST_SLOT_FRAGMENTS, fragments), gpu::writes(STREAM_TEST_SLOT_QUADS, quads)};
  pass.groups = {static_cast<std::uint32_t>((streams.ranges.size() + 63) / 64), 1, 1};
  recorder.compute(pass);
  recorder.run();
  const auto words = quads.as<std::uint32_t>();
  return {words.begin(), words.end()};
}

// The same fragments for the transcription.
PixelStreams given_to_paper(const Streams& streams, const WordLayout& layout) {
  PixelStreams given;
  for (const StreamTestFragment& f : streams.fragments) {
    const std::uint32_t slopes = to_half(f.depth.y) | std::uint32_t{to_half(f.depth.z)} << 16;
    given.fragments.push_back(stream_fragment(f, slopes, layout));
  }
  for (const glm::uvec2& range : streams.ranges) given.ends.push_back(range.x + range.y);
  return given;
}

Totals expect_same_surfaces(const Case& wanted, std::uint32_t seed) {
  const Streams streams = random_streams(wanted, seed);
  const WordLayout layout{wanted.options.samples, wanted.options.surfaces, wanted.varying_roughness, wanted.emissive};
  return expect_same_surfaces(wanted.options, layout, given_to_paper(streams, layout),
                              run_on_device(wanted, layout, streams));
}

TEST(StreamingStream, LeavesTheSurfacesOfThePaperOn100000Pixels) {
  // In parts that fit the smallest range a storage buffer may have.
  Case wanted;
  wanted.pixels = 25000;
  Totals totals;
  for (std::uint32_t part = 0; part < 4; ++part) totals += expect_same_surfaces(wanted, 1 + part);
  // The streams are worth something: every path was taken often.
  EXPECT_GT(totals.merges, 50000u);
  EXPECT_GT(totals.dropped, 50000u);
  EXPECT_GT(totals.flags, 10000u);
  EXPECT_LT(totals.flags, 99000u);
  EXPECT_GT(totals.full, 50000u);
}

TEST(StreamingStream, AgreesForEveryNumberOfSurfacesAndSamples) {
  std::uint32_t seed = 100;
  for (const std::uint32_t samples : {4u, 8u, 16u, 32u})
    for (std::uint32_t surfaces = 1; surfaces <= STREAM_MAX_SURFACES; ++surfaces) {
      SCOPED_TRACE(testing::Message() << samples << " samples, " << surfaces << " surfaces");
      Case wanted;
      wanted.options.samples = samples;
      wanted.options.surfaces = surfaces;
      wanted.varying_roughness = surfaces % 2 == 0;
      wanted.emissive = surfaces > 2;
      // The depth test's stored masks are what shows, so that the technique discards by them.
      for (const auto& [depth_tested, by_resolved] : {std::pair{false, false}, {false, true}, {true, true}}) {
        wanted.options.depth_tested = depth_tested;
        wanted.options.discard_by_resolved = by_resolved;
        expect_same_surfaces(wanted, seed++);
      }
    }
}

TEST(StreamingStream, AgreesWithEachConditionSwitchedOffAndWithOtherWeights) {
  std::uint32_t seed = 200;
  for (const std::uint32_t off : {1u, 2u, 4u, 7u})
    for (const bool by_coverage : {false, true}) {
      SCOPED_TRACE(testing::Message() << "conditions off: " << off << ", weights by coverage: " << by_coverage);
      Case wanted;
      wanted.options.merge_normals = (off & 1u) == 0;
      wanted.options.merge_depth = (off & 2u) == 0;
      wanted.options.merge_coverage = (off & 4u) == 0;
      wanted.options.weight_by_coverage = by_coverage;
      wanted.options.cos_normal_angle = std::cos(0.4f);
      expect_same_surfaces(wanted, seed++);
    }
}

}  // namespace
}  // namespace subpixel::streaming_test
