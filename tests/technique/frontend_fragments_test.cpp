// Fragments per pass, against the host's own coverage of what set-up left.
#include <gtest/gtest.h>

#include "tests/technique/frontend_fixture.hpp"
#include "tests/technique/scene_device_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 32;

// Corners in pixels.
ScreenTriangle triangle(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1, std::int64_t x2,
                        std::int64_t y2, float z) {
  return {{{256 * x0, 256 * y0}, {256 * x1, 256 * y1}, {256 * x2, 256 * y2}}, {z, z, z}};
}

TEST(Fragments, OfTrianglesThatCanBeCountedByHand) {
  for (const std::uint32_t samples : {1u, 8u, 64u}) {
    // A right triangle with sides of 4 pixels whose diagonal cuts 4 of them in half: at one sample, whose centres then
    // lie on a right edge, 6; more samples see all 10.
    FrontendRun one(test_device(), screen_capture({triangle(8, 8, 12, 8, 8, 12, 0.5f)}, kWidth, kHeight), kWidth,
                    kHeight, samples);
    one.run();
    EXPECT_EQ(one.frontend.count_fragments(kWidth, kHeight), samples == 1 ? 6u : 10u) << samples;

    // The same behind one that covers the frame.
    FrontendRun two(
        test_device(),
        screen_capture({triangle(0, 0, 128, 0, 0, 64, 0.75f), triangle(8, 8, 12, 8, 8, 12, 0.5f)}, kWidth, kHeight),
        kWidth, kHeight, samples);
    two.run();
    constexpr std::uint64_t kScreen = std::uint64_t{kWidth} * kHeight;
    EXPECT_EQ(two.frontend.count_fragments(kWidth, kHeight), kScreen + (samples == 1 ? 6u : 10u));
  }
}

TEST(Fragments, EqualTheHostsCountOnRandomTriangles) {
  Numbers numbers(17);
  std::vector<ScreenTriangle> triangles;
  for (int i = 0; i < 600; ++i) {
    const std::int64_t size = std::int64_t{64} << numbers.whole(0, 7);
    const std::int64_t x = numbers.whole(0, 256 * kWidth), y = numbers.whole(0, 256 * kHeight);
    ScreenTriangle t;
    for (int k = 0; k < 3; ++k) {
      t.corner[k] = {x + numbers.whole(-size, size), y + numbers.whole(-size, size)};
      t.z[k] = static_cast<float>(numbers.real(0.1, 0.9));
    }
    triangles.push_back(t);
  }
  for (const std::uint32_t samples : {1u, 4u, 64u})
    for (const auto small : {SmallTriangles::in_lists, SmallTriangles::as_hulls}) {
      FrontendRun run(test_device(), screen_capture(triangles, kWidth, kHeight), kWidth, kHeight, samples, small);
      run.run();
      std::uint64_t all = 0;
      for (const SetUpTriangle& t : run.triangles) {
        const PixelBox box = pixel_box(t.exact, kWidth, kHeight);
        std::uint64_t fragments = 0;
        for (std::int64_t y = box.y0; y < box.y1; ++y)
          for (std::int64_t x = box.x0; x < box.x1; ++x) {
            bool covered = false;
            for (std::uint32_t i = 0; i < samples && !covered; ++i)
              covered = t.exact.covers(sample_point(x, y, samples, i));
            fragments += covered ? 1 : 0;
          }
        all += fragments;
      }
      EXPECT_EQ(run.frontend.count_fragments(kWidth, kHeight), all) << samples;
    }
}

}  // namespace
}  // namespace subpixel::replay
