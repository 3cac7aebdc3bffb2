// The front-end's four samples a pixel against the device's own rasteriser, which was written by others: the same
// triangles, the same sample positions, compared sample by sample.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/technique/frontend_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kSide = 256, kSamples = 4;
constexpr std::int64_t kFine = 16;  // corner positions in 1/16 of the snapping grid's unit

struct FineTriangle {
  GridPoint corner[3];  // 1/4096 pixel
  float z = 0.5f;
};

capture::Capture fine_capture(const std::vector<FineTriangle>& triangles) {
  std::vector<float> positions;
  constexpr std::int64_t kHalf = kFine * 128 * kSide;
  for (const auto& t : triangles)
    for (const GridPoint& corner : t.corner) {
      // Exact for coordinates below 2^24.
      positions.push_back(static_cast<float>(corner.x - kHalf) / static_cast<float>(kHalf));
      positions.push_back(static_cast<float>(corner.y - kHalf) / static_cast<float>(kHalf));
      positions.push_back(t.z);
    }
  return triangle_list_capture(positions, glm::dmat4(1.0));
}

// The triangle the device's rasteriser leaves at each sample, its number in the draw.
std::vector<std::uint32_t> driver_samples(gpu::Device& device, FrontendRun& run) {
  gpu::PassRecorder recorder(device);
  gpu::ImageDescription target{"driver triangles",
                               VK_FORMAT_R32_UINT,
                               kSide,
                               kSide,
                               1,
                               1,
                               VK_SAMPLE_COUNT_4_BIT,
                               VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                               false};
  gpu::Image& image = recorder.image(target);
  target.name = "driver depth";
  target.format = VK_FORMAT_D32_SFLOAT;
  target.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  gpu::Image& depth = recorder.image(target);
  gpu::Buffer& samples = recorder.buffer("samples", std::uint64_t{kSide} * kSide * kSamples * 4);

  gpu::RasterPass pass;
  pass.name = "driver";
  pass.pipeline.vertex = "tests/driver_triangle.vert";
  pass.pipeline.fragment = "tests/driver_triangle.frag";
  pass.pipeline.constants = run.frontend.constants();
  pass.pipeline.targets.samples = VK_SAMPLE_COUNT_4_BIT;
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_GREATER;
  pass.pipeline.depth_write = true;
  pass.colours = {{image}};
  pass.clear_colours = {{SUBPIXEL_NO_TRIANGLE, 0, 0, 0}};
  pass.depth = &depth;
  pass.bindings = {gpu::uniform(run.scene.frame_constants)};
  pass.push = gpu::PushConstants(run.frontend.hull_push(pass, 0));
  const auto corners = static_cast<std::uint32_t>(3 * run.scene.triangle_count());
  pass.draws = [corners](gpu::DrawEncoder& encoder) { encoder.draw(corners); };
  recorder.raster(std::move(pass));

  gpu::ComputePass read;
  read.name = "read";
  read.shader = "tests/read_driver_samples.comp";
  read.bindings = {gpu::samples(TEST_SLOT_IMAGE, image), gpu::writes(TEST_SLOT_SAMPLES, samples)};
  read.groups = {kSide * kSide / 64, 1, 1};
  recorder.compute(std::move(read));
  recorder.run();
  const auto words = samples.as<std::uint32_t>();
  return {words.begin(), words.end()};
}

struct Comparison {
  std::uint64_t samples = 0, covered = 0, differing = 0, unexplained = 0;
};

// A difference is explained when the sample is within one grid unit (1/256 pixel) of a true edge of one of the two
// triangles: each rasteriser's snapping may move an edge by up to 0.71 units.
Comparison compare(gpu::Device& device, const std::vector<FineTriangle>& triangles) {
  FrontendRun run(device, fine_capture(triangles), kSide, kSide, kSamples);
  run.run();
  std::vector<std::uint32_t> source_of(1);
  for (const auto& t : run.triangles) {
    if (t.record >= source_of.size()) source_of.resize(t.record + 1);
    source_of[t.record] = t.source;
  }
  const std::vector<std::uint32_t> driver = driver_samples(device, run);
  const auto close = [&](std::uint32_t triangle, GridPoint p) {
    if (triangle == SUBPIXEL_NO_TRIANGLE) return false;
    const auto& corner = triangles[triangle].corner;
    return ExactTriangle(corner[0], corner[1], corner[2]).distance_to_edges({kFine * p.x, kFine * p.y}) <= kFine;
  };
  Comparison result;
  for (std::int64_t py = 0; py < kSide; ++py)
    for (std::int64_t px = 0; px < kSide; ++px)
      for (std::uint32_t s = 0; s < kSamples; ++s) {
        const VisibleSample& seen = run.seen()[run.place(px, py, s)];
        const std::uint32_t ours =
            seen.triangle == SUBPIXEL_NO_TRIANGLE ? SUBPIXEL_NO_TRIANGLE : source_of.at(seen.triangle);
        const std::uint32_t theirs = driver[run.place(px, py, s)];
        ++result.samples;
        result.covered += theirs == SUBPIXEL_NO_TRIANGLE ? 0 : 1;
        if (ours == theirs) continue;
        ++result.differing;
        const GridPoint p = sample_point(px, py, kSamples, s);
        result.unexplained += close(ours, p) || close(theirs, p) ? 0 : 1;
      }
  return result;
}

// Boxes of all sizes around a point of [low, high]^2, on multiples of `step` fine units; smaller ones nearer.
std::vector<FineTriangle> random_triangles(Numbers& numbers, int count, std::int64_t low, std::int64_t high,
                                           std::int64_t step) {
  std::vector<FineTriangle> triangles;
  for (int i = 0; i < count; ++i) {
    FineTriangle t;
    const double part = static_cast<double>(i) / count;
    const std::int64_t size = std::llround(static_cast<double>(high - low) * 0.6 * std::pow(1 - part, 4)) + 16 * kFine;
    const std::int64_t x = numbers.whole(low, high), y = numbers.whole(low, high);
    for (GridPoint& corner : t.corner) {
      const auto within = [&](std::int64_t at) {
        return std::clamp(at + numbers.whole(-size / 2, size / 2), low, high) / step * step;
      };
      corner.x = within(x);
      corner.y = within(y);
    }
    t.z = static_cast<float>(i + 1) / static_cast<float>(count + 2);
    triangles.push_back(t);
  }
  return triangles;
}

constexpr std::int64_t kImage = kFine * 256 * kSide;

TEST(Driver, SameSamplesForTrianglesOnTheGridWithinTheImage) {
  gpu::Device device;
  Numbers numbers(41);
  Comparison total;
  for (int round = 0; round < 8; ++round) {
    // In every other round on multiples of 1/16 pixel, where many edges go exactly through samples.
    const std::int64_t step = round % 2 == 0 ? kFine : 16 * kFine;
    const Comparison one = compare(device, random_triangles(numbers, 3000, 0, kImage, step));
    total.samples += one.samples;
    total.covered += one.covered;
    total.differing += one.differing;
  }
  fmt::print("on the grid: {} samples, {} covered, {} differ from the driver's\n", total.samples, total.covered,
             total.differing);
  EXPECT_GT(total.covered, total.samples / 2);
  EXPECT_EQ(total.differing, 0u);
}

TEST(Driver, OtherSamplesOnlyWhereSnappingExplainsThem) {
  gpu::Device device;
  Numbers numbers(43);
  Comparison total;
  for (int round = 0; round < 8; ++round) {
    // Off the grid and over the image's borders, where the driver clips and we don't.
    const Comparison one = compare(device, random_triangles(numbers, 3000, -kImage / 2, kImage + kImage / 2, 1));
    total.samples += one.samples;
    total.covered += one.covered;
    total.differing += one.differing;
    total.unexplained += one.unexplained;
  }
  fmt::print("off the grid: {} samples, {} covered, {} differ from the driver's, {} of them unexplained\n",
             total.samples, total.covered, total.differing, total.unexplained);
  EXPECT_GT(total.covered, total.samples / 2);
  EXPECT_EQ(total.unexplained, 0u);
  EXPECT_LE(total.differing * 1000, total.covered);
}

}  // namespace
}  // namespace subpixel::replay
