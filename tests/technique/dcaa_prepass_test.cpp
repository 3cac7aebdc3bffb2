// The z-prepass against the visibility of all 64 samples: no visible sample lies behind its bound.
#include <gtest/gtest.h>

#include "replay/techniques/dcaa_passes.hpp"
#include "scenes/generate/generate.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"
#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

struct Found {
  std::uint32_t samples_behind = 0, covered_pixels = 0, bounded_pixels = 0;
};

Found compare(const capture::Capture& capture, std::uint32_t width, std::uint32_t height) {
  gpu::Device& device = test_device();
  FrontendRun run(device, capture, width, height, 64);
  gpu::Image& image = record_depth_bound(run.recorder, run.setup(), {.options = DCAA_PREPASS});
  run.run();
  const auto texels = texels_of<glm::uvec4>(device, image);
  Found found;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const glm::uvec4 words = texels[y * width + x];
      const glm::dvec3 plane(std::bit_cast<float>(words.x), std::bit_cast<float>(words.y),
                             std::bit_cast<float>(words.z));
      bool covered = true;
      for (std::uint32_t s = 0; s < 64; ++s) {
        const auto [ox, oy] = gpu_types::sample_offset(64, s);
        const double bound = plane.x + plane.y * ox / 128 + plane.z * oy / 128;
        const std::uint32_t bits = run.seen()[run.place(x, y, s)].depth_bits;
        const double slack = 0x1p-20 * (plane.x + std::abs(plane.y) + std::abs(plane.z));
        found.samples_behind += bound > static_cast<double>(std::bit_cast<float>(bits)) + slack ? 1 : 0;
        covered = covered && bits != 0;
      }
      found.covered_pixels += covered ? 1 : 0;
      found.bounded_pixels += words.x != 0 ? 1 : 0;
      EXPECT_TRUE(covered || words.x == 0) << "pixel " << x << " " << y << " is not covered and has a bound";
    }
  return found;
}

TEST(DcaaPrepass, NoVisibleSampleIsBehindTheBound) {
  for (const char* scene : {"grass", "city", "foliage", "fur"}) {
    const Found found = compare(capture::generate(scene, {1, 64, 36, 1, 0.05}), 64, 36);
    EXPECT_EQ(found.samples_behind, 0u) << scene;
    // Worth something: most pixels that are covered have one.
    EXPECT_GT(found.bounded_pixels, found.covered_pixels * 3 / 4) << scene;
    EXPECT_GT(found.covered_pixels, 100u) << scene;
  }
}

TEST(DcaaPrepass, RulesOutNothingThatShowsInRandomTriangles) {
  Numbers numbers(5);
  for (int round = 0; round < 4; ++round) {
    std::vector<ScreenTriangle> triangles(400);
    const std::int64_t size = 64 << (2 * round);
    for (auto& t : triangles) {
      const std::int64_t x = numbers.whole(-500, 32 * 256 + 500), y = numbers.whole(-500, 32 * 256 + 500);
      for (int k = 0; k < 3; ++k) {
        t.corner[k] = {x + numbers.whole(-size, size), y + numbers.whole(-size, size)};
        t.z[k] = static_cast<float>(numbers.real(0.01, 0.99));
      }
    }
    EXPECT_EQ(compare(screen_capture(triangles, 32, 32), 32, 32).samples_behind, 0u) << "size " << size;
  }
}

}  // namespace
}  // namespace subpixel::replay
