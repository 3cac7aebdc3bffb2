// The shaders' algorithm 1 against its transcription, on streams of random fragments.
#include <gtest/gtest.h>

#include <random>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/include/shared_types.h"
#include "shaders/tests/dcaa_test_interface.h"
#include "tests/technique/dcaa_transcription.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::dcaa_test {
namespace {

using gpu_types::DcaaTestFragment;

struct Streams {
  std::vector<glm::uvec4> ranges;  // first fragment, count, pixel
  std::vector<DcaaTestFragment> fragments;
};

// Streams in which every outcome is frequent: a few planes a pixel that fragments share and leave by small amounts,
// masks of a few samples, of parts of the pixel, or of all of it.
Streams random_streams(const Options& options, std::uint32_t pixels, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto unit_real = [&] { return std::uniform_real_distribution<float>(0, 1)(random); };
  const auto below = [&](std::uint32_t n) { return std::uniform_int_distribution<std::uint32_t>(0, n - 1)(random); };
  const auto bits = [&] { return std::uint64_t{random()} << 32 | random(); };
  const std::uint64_t all = options.samples == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << options.samples) - 1;
  Streams streams;
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
    struct Plane {
      Vector normal;
      float depth = 0;
    };
    std::vector<Plane> planes(1 + below(9));
    const float middle = std::exp2(-12.0f * unit_real()), spread = std::exp2(-1.0f - 8.0f * unit_real());
    for (auto& plane : planes)
      plane = {{unit_real() - 0.5f, unit_real() - 0.5f, 0.6f * unit_real()},
               middle * (1.0f + spread * (unit_real() - 0.5f))};
    const std::uint32_t count = 1 + below(60);
    streams.ranges.emplace_back(static_cast<std::uint32_t>(streams.fragments.size()), count, below(640), below(360));
    for (std::uint32_t i = 0; i < count; ++i) {
      const Plane& plane = planes[below(static_cast<std::uint32_t>(planes.size()))];
      const float tilt = 0.3f * unit_real() * unit_real();
      std::uint64_t mask = bits() & bits() & all;
      if (below(3) != 0) mask &= bits();
      if (below(3) != 0) mask &= bits();
      if (below(16) == 0) mask = all;
      if (mask == 0) mask = std::uint64_t{1} << below(options.samples);
      DcaaTestFragment fragment{};
      fragment.facet_depth = {
          plane.normal.x + tilt * (unit_real() - 0.5f), plane.normal.y + tilt * (unit_real() - 0.5f),
          plane.normal.z + tilt * (unit_real() - 0.5f), plane.depth * (1.0f + 2e-4f * (unit_real() - 0.5f))};
      fragment.words = {random(), to_octahedral({unit_real() - 0.5f, unit_real() - 0.5f, unit_real() - 0.5f}, 16),
                        random() & 255u, 0};
      fragment.coverage = {static_cast<std::uint32_t>(mask), static_cast<std::uint32_t>(mask >> 32), 0, 0};
      streams.fragments.push_back(fragment);
    }
  }
  return streams;
}

// 640x360 with a horizontal field of view of 90 degrees, looking along -z.
gpu_types::DcaaView test_view() {
  gpu_types::DcaaView view{};
  view.ray_dx = {2.0f / 640, 0, 0, -1e-4f};
  view.ray_dy = {0, -2.0f / 640, 0, 0.9f};
  view.ray0 = {-319.5f / 320, 179.5f / 320, -1, 0};
  view.terms = {1, 0.0001f, 0.1f, 0};
  return view;
}

PixelView at_pixel(const gpu_types::DcaaView& view, std::uint32_t x, std::uint32_t y) {
  PixelView at;
  at.dx = {view.ray_dx.x, view.ray_dx.y, view.ray_dx.z};
  at.dy = {view.ray_dy.x, view.ray_dy.y, view.ray_dy.z};
  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  at.ray = {view.ray0.x + (fx * at.dx.x + fy * at.dy.x), view.ray0.y + (fx * at.dx.y + fy * at.dy.y),
            view.ray0.z + (fx * at.dx.z + fy * at.dy.z)};
  at.rays_differ = view.terms.x;
  at.scale = view.terms.y;
  at.place = view.terms.z;
  at.most_along = view.ray_dx.w;
  at.most_slope = view.ray_dy.w;
  return at;
}

std::uint32_t facet_words(const Options& o) {
  return o.normal_format == DCAA_NORMAL_3X32 ? 3 : 1;
}
std::uint32_t surface_words(const Options& o) {
  return (o.samples == 64 ? 2 : 1) + facet_words(o) + 3 + (o.depth_bits == 32 ? 1 : 0) + (o.second_moments ? 3 : 0);
}
std::uint32_t state_words(const Options& o) {
  return (1 + o.surfaces * surface_words(o) + 3) / 4 * 4;
}

Surface read_surface(const Options& o, const std::uint32_t* w) {
  Surface s;
  s.coverage = *w++;
  if (o.samples == 64) s.coverage |= std::uint64_t{*w++} << 32;
  for (std::uint32_t i = 0; i < facet_words(o); ++i) s.facet[i] = *w++;
  for (std::size_t i = 0; i < 4; ++i) s.albedo[i] = static_cast<std::uint8_t>(w[0] >> (8 * i));
  s.normal = w[1];
  s.roughness = static_cast<std::uint8_t>(w[2]);
  const std::uint32_t shift = o.depth_bits == 32 ? 0 : 28 - o.depth_bits;
  s.depth = std::bit_cast<float>(o.depth_bits == 32 ? w[3] : (96u << 23) + (w[2] >> 8 << shift));
  if (!o.second_moments) return s;
  w += o.depth_bits == 32 ? 4 : 3;
  for (std::size_t i = 0; i < 3; ++i) {
    s.moments[i] = static_cast<std::uint16_t>(w[i]);
    s.moments[3 + i] = static_cast<std::uint16_t>(w[i] >> 16);
  }
  return s;
}

std::vector<std::uint32_t> run_on_device(const Options& o, const Streams& streams) {
  gpu::Device& device = replay::test_device();
  gpu::PassRecorder recorder(device);
  gpu::Buffer frame(device, "frame", sizeof(gpu_types::FrameConstants));
  gpu::Buffer& ranges = recorder.buffer("ranges", streams.ranges.size() * sizeof(glm::uvec4));
  std::copy(streams.ranges.begin(), streams.ranges.end(), ranges.as<glm::uvec4>().begin());
  gpu::Buffer& fragments = recorder.buffer("fragments", streams.fragments.size() * sizeof(DcaaTestFragment));
  std::copy(streams.fragments.begin(), streams.fragments.end(), fragments.as<DcaaTestFragment>().begin());
  gpu::Buffer& view = recorder.buffer("view", sizeof(gpu_types::DcaaView));
  view.as<gpu_types::DcaaView>()[0] = test_view();
  gpu::Buffer& words = recorder.buffer("state", streams.ranges.size() * state_words(o) * 4);
  gpu::ComputePass pass;
  pass.name = "stream";
  pass.shader = "tests/dcaa_stream.comp";
  pass.constants = {{CONSTANT_SAMPLES, o.samples},
                    {CONSTANT_FEATURES, FEATURE_VARYING_ROUGHNESS | FEATURE_METAL},
                    {DCAA_CONSTANT_SURFACES, o.surfaces},
                    {DCAA_CONSTANT_COS_NORMAL_ANGLE, std::bit_cast<std::uint32_t>(o.cos_normal_angle)},
                    {DCAA_CONSTANT_OPTIONS,
                     (o.second_merge && !o.nearest ? DCAA_SECOND_MERGE : 0u) | (o.keep_front ? DCAA_KEEP_FRONT : 0u) |
                         (o.weight_by_shown ? DCAA_WEIGHT_SHOWN : 0u) | (o.distribution ? DCAA_DISTRIBUTION : 0u) |
                         (o.nearest ? DCAA_NEAREST : 0u) | (o.second_moments ? DCAA_SECOND_MOMENTS : 0u) |
                         (o.shown_part ? DCAA_SHOWN_PART : 0u)},
                    {DCAA_CONSTANT_NORMAL_FORMAT, o.normal_format},
                    {DCAA_CONSTANT_DEPTH_BITS, o.depth_bits},
                    {DCAA_CONSTANT_DEPTH_REACH, std::bit_cast<std::uint32_t>(o.depth_reach)},
                    {DCAA_CONSTANT_INVERSE_LENGTH, std::bit_cast<std::uint32_t>(o.inverse_length)}};
  pass.bindings = {gpu::uniform(frame), gpu::reads(DCAA_TEST_SLOT_RANGES, ranges),
                   gpu::reads(DCAA_TEST_SLOT_FRAGMENTS, fragments), gpu::reads(DCAA_TEST_SLOT_VIEW, view),
                   gpu::writes(DCAA_TEST_SLOT_WORDS, words)};
  pass.groups = {static_cast<std::uint32_t>((streams.ranges.size() + 63) / 64), 1, 1};
  recorder.compute(pass);
  recorder.run();
  const auto left = words.as<std::uint32_t>();
  return {left.begin(), left.end()};
}

struct Totals {
  std::uint64_t first_merges = 0, second_merges = 0, discards = 0, full = 0;
};

// Bit for bit: every surface and every count of every pixel.
void expect_same_surfaces(const Options& o, std::uint32_t pixels, std::uint32_t seed, Totals& totals) {
  const Streams streams = random_streams(o, pixels, seed);
  const std::vector<std::uint32_t> words = run_on_device(o, streams);
  std::uint32_t wrong = 0;
  for (std::size_t i = 0; i < streams.ranges.size(); ++i) {
    const glm::uvec4 range = streams.ranges[i];
    Pixel paper(o, at_pixel(test_view(), range.z, range.w));
    for (std::uint32_t k = 0; k < range.y; ++k) {
      const DcaaTestFragment& f = streams.fragments[range.x + k];
      Surface s;
      s.coverage = std::uint64_t{f.coverage.y} << 32 | f.coverage.x;
      s.facet = to_facet({f.facet_depth.x, f.facet_depth.y, f.facet_depth.z}, o.normal_format);
      s.depth = stored_depth(f.facet_depth.w, o.depth_bits);
      for (std::size_t c = 0; c < 4; ++c) s.albedo[c] = static_cast<std::uint8_t>(f.words.x >> (8 * c));
      s.normal = f.words.y;
      s.roughness = static_cast<std::uint8_t>(f.words.z);
      if (o.second_moments) s.moments = moments_of(s.normal, o.distribution);
      paper.add(s);
    }
    const std::uint32_t* const state = words.data() + i * state_words(o);
    const Counts& counts = paper.counts();
    bool same = (state[0] & 15u) == paper.surfaces().size() && (state[0] >> 4 & 4095u) == counts.first_merges &&
                (state[0] >> 16 & 255u) == counts.second_merges && state[0] >> 24 == counts.discards;
    for (std::size_t s = 0; same && s < paper.surfaces().size(); ++s)
      same = read_surface(o, state + 1 + s * surface_words(o)) == paper.surfaces()[s];
    wrong += same ? 0 : 1;
    totals.first_merges += counts.first_merges;
    totals.second_merges += counts.second_merges;
    totals.discards += counts.discards;
    totals.full += paper.surfaces().size() == o.surfaces ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0u) << "of " << streams.ranges.size() << " pixels";
}

TEST(DcaaStream, LeavesTheSurfacesOfThePaperOn100000Pixels) {
  Totals totals;
  for (std::uint32_t part = 0; part < 4; ++part) expect_same_surfaces({}, 25000, 1 + part, totals);
  // The streams are worth something: every path was taken often.
  EXPECT_GT(totals.first_merges, 300000u);
  EXPECT_GT(totals.second_merges, 100000u);
  EXPECT_GT(totals.discards, 100000u);
  EXPECT_GT(totals.full, 50000u);
  EXPECT_LT(totals.full, 95000u);
}

TEST(DcaaStream, NearestLeavesTheSurfacesOfItsRulesOn100000Pixels) {
  Totals totals;
  for (std::uint32_t part = 0; part < 4; ++part) {
    Options o;
    o.nearest = o.shown_part = o.weight_by_shown = true;
    o.surfaces = part == 2 ? 8 : 4;
    o.samples = part == 1 ? 16 : 64;
    SCOPED_TRACE(testing::Message() << "part " << part);
    expect_same_surfaces(o, 25000, 600 + part, totals);
  }
  EXPECT_GT(totals.first_merges, 200000u);
  EXPECT_GT(totals.second_merges, 100000u);
  EXPECT_EQ(totals.discards, 0u);
}

TEST(DcaaStream, AgreesForEveryNumberOfSurfacesAndSamples) {
  std::uint32_t seed = 100;
  Totals totals;
  for (const std::uint32_t samples : {16u, 32u, 64u})
    for (const std::uint32_t surfaces : {1u, 5u, 8u}) {
      if (samples != 64 && surfaces != 5) continue;
      SCOPED_TRACE(testing::Message() << samples << " samples, " << surfaces << " surfaces");
      Options o;
      o.samples = samples;
      o.surfaces = surfaces;
      expect_same_surfaces(o, 2000, seed++, totals);
    }
}

TEST(HybridStream, LeavesTheSurfacesOfItsRulesOn100000Pixels) {
  Totals totals;
  for (std::uint32_t part = 0; part < 4; ++part) {
    Options o;
    o.nearest = true;
    o.distribution = part != 3;
    o.weight_by_shown = part != 1;
    o.shown_part = part < 2;
    o.surfaces = part == 2 ? 8 : 4;
    o.samples = part == 2 ? 32 : 64;
    o.inverse_length = part == 1 ? 100.0f : 1.0f;
    SCOPED_TRACE(testing::Message() << "part " << part);
    expect_same_surfaces(o, 25000, 300 + part, totals);
  }
  EXPECT_GT(totals.first_merges, 300000u);
  EXPECT_GT(totals.second_merges, 100000u);
  EXPECT_EQ(totals.discards, 0u);
}

TEST(HybridStream, SecondMomentsAreBlendedAsTheirMeans) {
  Totals totals;
  for (const std::uint32_t surfaces : {4u, 8u}) {
    Options o;
    o.nearest = o.distribution = o.weight_by_shown = o.second_moments = true;
    o.surfaces = surfaces;
    o.samples = surfaces == 8 ? 16 : 64;
    expect_same_surfaces(o, 10000, 500 + surfaces, totals);
  }
  EXPECT_GT(totals.first_merges, 50000u);
  EXPECT_GT(totals.second_merges, 10000u);
}

TEST(HybridStream, MeansWithLengthsUnderTheOldRules) {
  Options o;
  o.distribution = true;
  Totals totals;
  expect_same_surfaces(o, 10000, 400, totals);
  EXPECT_GT(totals.second_merges, 10000u);
}

TEST(DcaaStream, AgreesWithEachRuleSwitchedOffAndInOtherFormats) {
  std::uint32_t seed = 200;
  Totals totals;
  for (const std::uint32_t variant : {0u, 1u, 2u, 3u}) {
    SCOPED_TRACE(testing::Message() << "variant " << variant);
    Options o;
    o.second_merge = (variant & 1u) == 0;
    o.keep_front = (variant & 2u) == 0;
    o.weight_by_shown = variant > 1;
    o.depth_reach = 0.5f + static_cast<float>(variant % 2);
    o.normal_format = variant;
    o.depth_bits = std::array{32u, 16u, 20u, 24u}[variant];
    o.cos_normal_angle = std::cos(0.1f + 0.2f * static_cast<float>(variant));
    expect_same_surfaces(o, 2000, seed++, totals);
  }
}

}  // namespace
}  // namespace subpixel::dcaa_test
