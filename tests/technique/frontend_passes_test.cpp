// What the front-end promises to the passes after it: an ordered pixel, and a second geometry pass that finds every
// sample the first one left.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "replay/gpu/litmus.hpp"
#include "replay/techniques/deferred.hpp"
#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

TEST(Device, KeepsFragmentsOfAPixelInOrder) {
  gpu::Device device;
  std::uint64_t fragments = 0;
  for (const auto memory : {gpu::OrderedMemory::attachment, gpu::OrderedMemory::buffer}) {
    const gpu::LitmusResult result = gpu::run_order_litmus(device, memory);
    EXPECT_EQ(result.order_violations, 0u);
    EXPECT_EQ(result.lost_updates, 0u);
    fragments += result.fragments;
  }
  EXPECT_GE(fragments, 10'000'000u);
}

constexpr std::uint32_t kSide = 128, kDraws = 12;

// Tilted triangles that pierce each other, in draws of a colour each.
capture::Capture coloured_triangles(Numbers& numbers, std::uint32_t triangles_per_draw) {
  std::vector<ScreenTriangle> triangles;
  for (std::uint32_t i = 0; i < kDraws * triangles_per_draw; ++i) {
    ScreenTriangle t;
    const std::int64_t size = std::int64_t{64} << numbers.whole(0, 9);
    const std::int64_t x = numbers.whole(0, 256 * kSide), y = numbers.whole(0, 256 * kSide);
    for (int k = 0; k < 3; ++k) {
      t.corner[k].x = x + numbers.whole(-size, size);
      t.corner[k].y = y + numbers.whole(-size, size);
      t.z[k] = static_cast<float>(numbers.real(0.1, 0.9));
    }
    triangles.push_back(t);
  }
  capture::Capture capture = screen_capture(triangles, kSide, kSide);
  const capture::Draw all = capture.frames[0].draws[0];
  const capture::Material plain = capture.materials[0];
  capture.frames[0].draws.clear();
  capture.materials.clear();
  for (std::uint32_t d = 0; d < kDraws; ++d) {
    capture::Draw draw = all;
    draw.material = d;
    draw.index_count = draw.vertex_count = 3 * triangles_per_draw;
    draw.position.offset = std::uint64_t{36} * triangles_per_draw * d;
    capture::Material material = plain;
    material.base_colour = {static_cast<float>(d + 1) / kDraws, 0.5f, 0.25f, 1};
    capture.frames[0].draws.push_back(draw);
    capture.materials.push_back(material);
  }
  return capture;
}

class SecondPass : public testing::TestWithParam<std::uint32_t> {};

TEST_P(SecondPass, WritesTheSurfaceOfEveryVisibleSample) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(5 + n);
  FrontendRun run(device, coloured_triangles(numbers, 200), kSide, kSide, n);
  const FrameSetup setup = run.setup();
  gpu::Image& gbuffer = gbuffer_image(run.recorder, setup);
  const VisibleFragments visible = run.visible();
  const std::uint32_t group = gbuffer_group(n), words_per_texel = narrow_samples(setup) ? 2 : 4;
  std::vector<std::vector<std::uint32_t>> layers;  // of all groups
  for (std::uint32_t g = 0; g < n / group; ++g) {
    record_gbuffer(run.recorder, setup, visible, gbuffer, g);
    run.recorder.host([&] {
      for (std::uint32_t layer = 0; layer < group; ++layer) {
        const auto bytes = gpu::download(device, gbuffer, layer);
        auto& words = layers.emplace_back(bytes.size() / 4);
        std::memcpy(words.data(), bytes.data(), bytes.size());
      }
    });
  }
  run.run();

  // Records of draw d start at its first chunk.
  const auto material_of = [&](std::uint32_t record) {
    const auto records = run.frontend.records().as<gpu_types::TriangleRecord>();
    const std::uint32_t index = records[record].hull2_id.z;
    std::uint32_t material = 0;
    for (const DrawItem& draw : run.scene.draws())
      if (index >= draw.first_index && index < draw.first_index + 3 * draw.triangle_count) material = draw.material;
    return material;
  };
  std::uint64_t covered = 0, missing = 0;
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint64_t>> albedo_of_material;
  for (std::int64_t py = 0; py < kSide; ++py)
    for (std::int64_t px = 0; px < kSide; ++px)
      for (std::uint32_t s = 0; s < n; ++s) {
        const VisibleSample& seen = run.seen()[run.place(px, py, s)];
        const std::uint32_t albedo =
            layers[s][words_per_texel * (static_cast<std::size_t>(py) * kSide + static_cast<std::size_t>(px))];
        if (seen.triangle == SUBPIXEL_NO_TRIANGLE) continue;
        ++covered;
        missing += albedo == 0 ? 1 : 0;
        ++albedo_of_material[material_of(seen.triangle)][albedo];
      }
  EXPECT_GT(covered, std::uint64_t{kSide} * kSide * n / 2);
  EXPECT_EQ(missing, 0u) << "samples without a surface";
  EXPECT_EQ(albedo_of_material.size(), kDraws);
  std::map<std::uint32_t, std::uint32_t> material_of_albedo;
  for (const auto& [material, albedos] : albedo_of_material) {
    EXPECT_EQ(albedos.size(), 1u) << "material " << material << " has surfaces of others";
    EXPECT_TRUE(material_of_albedo.emplace(albedos.begin()->first, material).second);
  }
  fmt::print("{:2} samples: {} visible, {} without a surface\n", n, covered, missing);
}

// Triangles of all sizes, of which many lie in others' planes, and pieces of clipped ones among them.
capture::Capture tied_triangles(Numbers& numbers) {
  std::vector<ScreenTriangle> triangles;
  for (int i = 0; i < 6000; ++i) {
    ScreenTriangle t;
    const std::int64_t size = i % 50 == 0 ? std::int64_t{1} << 22 : std::int64_t{64} << numbers.whole(0, 7);
    const std::int64_t x = numbers.whole(0, 256 * kSide), y = numbers.whole(0, 256 * kSide);
    const auto level = static_cast<float>(numbers.whole(1, 4)) / 8;
    for (int k = 0; k < 3; ++k) {
      t.corner[k].x = x + numbers.whole(-size, size);
      t.corner[k].y = y + numbers.whole(-size, size);
      t.z[k] = level;
    }
    triangles.push_back(t);
  }
  return screen_capture(triangles, kSide, kSide);
}

// Samples that differ in triangle or depth, small triangles as hulls and, on `other_device`, by the other way.
std::uint64_t different_samples(const capture::Capture& capture, std::uint32_t width, std::uint32_t height,
                                std::uint32_t n, std::optional<SmallTriangles> way,
                                gpu::Device& other_device = test_device()) {
  const auto samples = [&](gpu::Device& device, std::optional<SmallTriangles> small) {
    FrontendRun run(device, capture, width, height, n, small);
    run.run();
    EXPECT_GT(run.frontend.small_count(), 1000u);
    return std::vector<VisibleSample>(run.seen().begin(), run.seen().end());
  };
  const auto hulls = samples(test_device(), SmallTriangles::as_hulls), other = samples(other_device, way);
  std::uint64_t different = 0;
  for (std::size_t i = 0; i < hulls.size(); ++i)
    different += hulls[i].triangle != other[i].triangle || hulls[i].depth_bits != other[i].depth_bits ? 1 : 0;
  return different;
}

// Of both sizes, one has blocks that the border cuts, whose lanes do not read together.
TEST_P(SecondPass, SmallTrianglesLeaveTheSameBitsInListsAndAsHulls) {
  const std::uint32_t n = GetParam();
  for (const std::uint32_t cut : {0u, 3u}) {
    Numbers numbers(17 + n);
    EXPECT_EQ(
        different_samples(coloured_triangles(numbers, 400), kSide - cut, kSide - cut, n, SmallTriangles::in_lists), 0u)
        << "tilted, " << cut;
    EXPECT_EQ(different_samples(tied_triangles(numbers), kSide - cut, kSide - cut, n, SmallTriangles::in_lists), 0u)
        << "tied, " << cut;
  }
}

// Small triangles of more bytes than a range of the device has, or one by one for each lane.
TEST_P(SecondPass, SmallTrianglesLeaveTheSameBitsByAddress) {
  const std::uint32_t n = GetParam();
  constexpr std::uint32_t kTriangles = 40'000;
  // With room for the samples that the test reads.
  static gpu::Device far({.largest_range = 2 << 20}), by_lane({.without = {gpu::kFragmentSubgroups}});
  ASSERT_GT(kTriangles * sizeof(gpu_types::SmallTriangle), far.info().max_storage_buffer_range);
  Numbers numbers(29 + n);
  std::vector<ScreenTriangle> triangles(kTriangles);
  for (ScreenTriangle& t : triangles) {
    const std::int64_t x = numbers.whole(0, 256 * kSide), y = numbers.whole(0, 256 * kSide);
    for (int k = 0; k < 3; ++k) {
      t.corner[k] = {x + numbers.whole(0, 700), y + numbers.whole(0, 700)};
      t.z[k] = static_cast<float>(numbers.real(0.1, 0.9));
    }
  }
  const capture::Capture capture = screen_capture(triangles, kSide, kSide);
  const std::uint32_t m = std::min(n, 16u);
  EXPECT_EQ(different_samples(capture, kSide, kSide, m, SmallTriangles::in_lists, far), 0u);
  EXPECT_EQ(different_samples(capture, kSide - 3, kSide - 3, m, SmallTriangles::in_lists, by_lane), 0u);
}

// More triangles in a block than drivers take that end long loops.
TEST(SmallLists, OfAnyLengthLeaveTheBitsOfHulls) {
  Numbers numbers(3);
  std::vector<ScreenTriangle> triangles;
  for (int i = 0; i < 150000; ++i) {
    const std::int64_t x = 256 * 40, y = 256 * 40;
    ScreenTriangle t;
    for (int k = 0; k < 3; ++k) {
      t.corner[k] = {x + numbers.whole(0, 1023), y + numbers.whole(0, 511)};
      // Later ones are nearer: what a cut list lacks would be seen.
      t.z[k] = 0.1f + static_cast<float>(i) * 5e-6f;
    }
    triangles.push_back(t);
  }
  EXPECT_EQ(different_samples(screen_capture(triangles, kSide, kSide), kSide, kSide, 8, std::nullopt), 0u);
}

INSTANTIATE_TEST_SUITE_P(Samples, SecondPass, testing::Values(1u, 4u, 8u, 16u, 64u));

}  // namespace
}  // namespace subpixel::replay
