// A fan and a closed mesh on the grid that set-up snapped them to: each sample is covered once, by exact arithmetic,
// and the device finds the same samples.
#include <gtest/gtest.h>

#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

TEST(HardCaseMeshes, EachSampleIsCoveredOnce) {
  constexpr std::uint32_t kWidth = 64, kHeight = 48, kSpokes = 61;
  constexpr double kRadius = 0.22 * kWidth;  // pixels
  for (const std::uint32_t samples : {8u, 64u}) {
    FrontendRun run(test_device(), capture::hard_shared_edges({.frames = 1, .width = kWidth, .height = kHeight}),
                    kWidth, kHeight, samples);
    run.run();
    std::vector<int> covering(run.seen().size(), 0), of_fan = covering;
    for (const SetUpTriangle& t : run.triangles) {
      const PixelBox box = pixel_box(t.exact, kWidth, kHeight);
      for (std::int64_t y = box.y0; y < box.y1; ++y)
        for (std::int64_t x = box.x0; x < box.x1; ++x)
          for (std::uint32_t s = 0; s < samples; ++s)
            if (t.exact.covers(sample_point(x, y, samples, s))) {
              ++covering[run.place(x, y, s)];
              if (t.source < kSpokes) ++of_fan[run.place(x, y, s)];
            }
    }
    std::size_t inside = 0;
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        for (std::uint32_t s = 0; s < samples; ++s) {
          const std::size_t at = run.place(x, y, s);
          ASSERT_LE(covering[at], 1) << x << ", " << y << " sample " << s;
          ASSERT_EQ(covering[at] == 1, run.seen()[at].triangle != SUBPIXEL_NO_TRIANGLE) << x << ", " << y;
          // The fan's inner circle, a pixel in: no sample may be missing.
          const GridPoint p = sample_point(x, y, samples, s);
          const double from_centre = std::hypot(static_cast<double>(p.x) / 256 - 0.25 * kWidth,
                                                static_cast<double>(p.y) / 256 - 0.5 * kHeight);
          if (from_centre > kRadius - 1) continue;
          ASSERT_EQ(of_fan[at], 1) << x << ", " << y << " sample " << s;
          ++inside;
        }
      }
    }
    EXPECT_GT(inside, 500u * samples);
  }
}

}  // namespace
}  // namespace subpixel::replay
