// Every decision of the front-end about a triangle and a sample against exact integer arithmetic on the host: random
// triangles of all shapes, at every sample count, from the capture to the visibility image.
//
// Each triangle has its own depth, so the host knows which of a sample's triangles is nearest. A decision shows in the
// image when the triangle is nearest, or would be if it covered the sample; only those are counted.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/technique/frontend_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kSide = 256;
constexpr std::int64_t kGridSide = 256 * kSide;
constexpr std::int64_t kGuard = 256 * SUBPIXEL_GUARD_BAND_PX;

struct Shapes {
  int small, pointed, medium, slivers, huge, clipped, degenerate;
};

GridPoint random_point(Numbers& numbers, std::int64_t low, std::int64_t high) {
  const std::int64_t x = numbers.whole(low, high);
  return {x, numbers.whole(low, high)};
}

// Corners within `size` grid units of each other, somewhere on the image.
ScreenTriangle box_triangle(Numbers& numbers, std::int64_t size) {
  const GridPoint at = random_point(numbers, -size, kGridSide);
  ScreenTriangle t;
  for (GridPoint& corner : t.corner) {
    const GridPoint offset = random_point(numbers, 0, size);
    corner = {at.x + offset.x, at.y + offset.y};
  }
  return t;
}

// All corners on samples, so that edges go exactly through samples too.
ScreenTriangle sample_triangle(Numbers& numbers, std::uint32_t n) {
  const std::int64_t x = numbers.whole(0, kSide - 1), y = numbers.whole(0, kSide - 1);
  ScreenTriangle t;
  for (GridPoint& corner : t.corner) {
    const std::int64_t dx = numbers.whole(0, 6), dy = numbers.whole(0, 6);
    corner = sample_point(x + dx, y + dy, n, static_cast<std::uint32_t>(numbers.whole(0, n - 1)));
  }
  return t;
}

// One to four grid units wide and up to 4000 pixels long, through a point of the image in any direction.
ScreenTriangle sliver(Numbers& numbers) {
  const GridPoint through = random_point(numbers, 0, kGridSide);
  const double length = 256 * std::exp2(numbers.real(0, 12)), part = numbers.real(0, 1);
  const double angle = numbers.whole(0, 3) == 0 ? static_cast<double>(numbers.whole(0, 7)) * 0.78539816339744831
                                                : numbers.real(0, 6.283185307179586);
  const glm::dvec2 along(std::cos(angle), std::sin(angle)), across(-along.y, along.x);
  const glm::dvec2 start = glm::dvec2(through.x, through.y) - part * length * along;
  const auto snapped = [](glm::dvec2 p) {
    // Within the guard band, so that it is not clipped.
    const auto limit = [](double v) { return std::clamp(std::llround(v), 256ll - kGuard, kGridSide + kGuard - 256ll); };
    return GridPoint{limit(p.x), limit(p.y)};
  };
  ScreenTriangle t;
  t.corner[0] = snapped(start);
  t.corner[1] = snapped(start + length * along);
  const double apex = numbers.whole(0, 2) == 0 ? 0.0 : numbers.real(0, 1);
  t.corner[2] = snapped(start + apex * length * along + static_cast<double>(numbers.whole(1, 4)) * across);
  return t;
}

// Anywhere in the guard band.
ScreenTriangle far_triangle(Numbers& numbers) {
  ScreenTriangle t;
  for (GridPoint& corner : t.corner) corner = random_point(numbers, 256 - kGuard, kGridSide + kGuard - 256);
  return t;
}

// An edge crosses the image and ends far beyond the guard band, so that pieces are drawn.
ScreenTriangle clipped_triangle(Numbers& numbers) {
  const GridPoint through = random_point(numbers, 0, kGridSide);
  const double angle = numbers.real(0, 6.283185307179586);
  const auto at = [&](double direction) {
    const double distance = static_cast<double>(kGuard) * std::exp2(numbers.real(0.5, 5));
    return GridPoint{through.x + std::llround(distance * std::cos(direction)),
                     through.y + std::llround(distance * std::sin(direction))};
  };
  ScreenTriangle t;
  t.corner[0] = at(angle);
  t.corner[1] = at(angle + 3.141592653589793 + numbers.real(-0.01, 0.01));
  t.corner[2] = at(angle + 1.5707963267948966 + numbers.real(-1, 1));
  return t;
}

ScreenTriangle degenerate_triangle(Numbers& numbers) {
  ScreenTriangle t = box_triangle(numbers, 4096);
  const GridPoint step{t.corner[1].x - t.corner[0].x, t.corner[1].y - t.corner[0].y};
  const std::int64_t factor = numbers.whole(-1, 3);
  t.corner[2] = {t.corner[0].x + factor * step.x, t.corner[0].y + factor * step.y};
  return t;
}

// Small shapes lie before large ones, so that most decisions show; the submission order is random.
std::vector<ScreenTriangle> random_triangles(Numbers& numbers, const Shapes& shapes, std::uint32_t n) {
  std::vector<ScreenTriangle> triangles;
  const auto add = [&](int count, auto make) {
    for (int i = 0; i < count; ++i) triangles.push_back(make());
  };
  add(shapes.clipped, [&] { return clipped_triangle(numbers); });
  add(shapes.huge, [&] { return far_triangle(numbers); });
  add(shapes.medium, [&] { return box_triangle(numbers, 256 * numbers.whole(3, 140)); });
  add(shapes.slivers, [&] { return sliver(numbers); });
  add(shapes.pointed, [&] { return sample_triangle(numbers, n); });
  add(shapes.small, [&] { return box_triangle(numbers, std::int64_t{2} << numbers.whole(0, 8)); });
  add(shapes.degenerate, [&] { return degenerate_triangle(numbers); });
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const float z = static_cast<float>(i + 1) / static_cast<float>(triangles.size() + 2);
    for (float& corner : triangles[i].z) corner = z;
  }
  for (std::size_t i = triangles.size(); i > 1; --i)
    std::swap(triangles[i - 1],
              triangles[static_cast<std::size_t>(numbers.whole(0, static_cast<std::int64_t>(i) - 1))]);
  return triangles;
}

bool same_corners(const ExactTriangle& a, const ExactTriangle& b) {
  for (int turn = 0; turn < 3; ++turn)
    if (a.corner(0) == b.corner(turn) && a.corner(1) == b.corner((turn + 1) % 3) &&
        a.corner(2) == b.corner((turn + 2) % 3))
      return true;
  return false;
}

// Calls `visit(px, py)` for the pixels that are not decided by one look at the pixel's square.
template <typename Visit>
void near_pixels(const ExactTriangle& t, std::uint32_t width, std::uint32_t height, Visit visit) {
  const PixelBox box = pixel_box(t, width, height);
  for (std::int64_t py = box.y0; py < box.y1; ++py)
    for (std::int64_t px = box.x0; px < box.x1; ++px)
      if (!t.misses_pixel(px, py)) visit(px, py);
}

std::uint64_t covered_samples(const ExactTriangle& t, std::uint32_t n) {
  std::uint64_t covered = 0;
  near_pixels(t, kSide, kSide, [&](std::int64_t px, std::int64_t py) {
    for (std::uint32_t s = 0; s < n; ++s) covered += t.covers(sample_point(px, py, n, s)) ? 1 : 0;
  });
  return covered;
}

// The nearest of the set-up triangles at each sample; of equal depths the first.
std::vector<VisibleSample> expected_samples(const FrontendRun& run) {
  std::vector<VisibleSample> expected(run.seen().size());
  for (const SetUpTriangle& t : run.triangles)
    near_pixels(t.exact, run.width, run.height, [&](std::int64_t px, std::int64_t py) {
      for (std::uint32_t s = 0; s < run.samples; ++s) {
        if (!t.exact.covers(sample_point(px, py, run.samples, s))) continue;
        const auto bits = std::bit_cast<std::uint32_t>(t.depth(px, py, gpu_types::sample_offset(run.samples, s)));
        VisibleSample& sample = expected[run.place(px, py, s)];
        if (bits > sample.depth_bits) sample = {bits, t.record};
      }
    });
  return expected;
}

struct Wrong {
  std::uint64_t triangle = 0, depth = 0;
};

Wrong wrong_samples(const FrontendRun& run) {
  const std::vector<VisibleSample> expected = expected_samples(run);
  Wrong wrong;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (run.seen()[i].triangle != expected[i].triangle)
      ++wrong.triangle;
    else if (run.seen()[i].depth_bits != expected[i].depth_bits)
      ++wrong.depth;
  }
  return wrong;
}

struct Decisions {
  std::uint64_t covered = 0, uncovered = 0;
};

// Of pixels near a triangle: decisions that the image shows.
Decisions shown_decisions(const FrontendRun& run) {
  Decisions decisions;
  for (const SetUpTriangle& t : run.triangles)
    near_pixels(t.exact, run.width, run.height, [&](std::int64_t px, std::int64_t py) {
      for (std::uint32_t s = 0; s < run.samples; ++s) {
        const VisibleSample& seen = run.seen()[run.place(px, py, s)];
        const auto bits = std::bit_cast<std::uint32_t>(t.depth(px, py, gpu_types::sample_offset(run.samples, s)));
        if (seen.triangle == t.record)
          ++decisions.covered;
        else if (bits > seen.depth_bits)
          ++decisions.uncovered;
      }
    });
  return decisions;
}

class Coverage : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Coverage, EveryDecisionIsExact) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(1000 + n);
  const bool many = n > 16;
  const Shapes shapes{6000, 2000, many ? 150 : 400, many ? 700 : 2000, 6, 12, 60};
  const std::vector<ScreenTriangle> triangles = random_triangles(numbers, shapes, n);
  FrontendRun run(device, screen_capture(triangles, kSide, kSide), kSide, kSide, n);
  run.run();

  std::vector<bool> live(triangles.size());
  std::uint64_t moved = 0, pieces = 0;
  for (const SetUpTriangle& t : run.triangles) {
    ASSERT_LT(t.source, triangles.size());
    live[t.source] = true;
    pieces += t.piece ? 1 : 0;
    const auto& corner = triangles[t.source].corner;
    if (!t.piece && (t.record != t.source || !same_corners(t.exact, {corner[0], corner[1], corner[2]}))) ++moved;
  }
  EXPECT_EQ(moved, 0u) << "triangles not at their snapped positions";
  EXPECT_GE(pieces, 12u);

  std::uint64_t culled = 0, lost = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (live[i]) continue;
    ++culled;
    lost += covered_samples({triangles[i].corner[0], triangles[i].corner[1], triangles[i].corner[2]}, n);
  }
  EXPECT_EQ(lost, 0u) << "samples of culled triangles";

  const Wrong wrong = wrong_samples(run);
  EXPECT_EQ(wrong.triangle, 0u) << "samples with another triangle than exact arithmetic gives";
  EXPECT_EQ(wrong.depth, 0u) << "samples with another depth than the plane's";
  const Decisions decisions = shown_decisions(run);
  fmt::print("{:2} samples: {} triangles, {} culled, {} pieces; {} decisions ({} covered): {} wrong\n", n,
             triangles.size(), culled, pieces, decisions.covered + decisions.uncovered, decisions.covered,
             wrong.triangle);
  // 10^7 in all; the pattern of one sample has 1/64 of the others' pairs.
  EXPECT_GE(decisions.covered + decisions.uncovered, n == 1   ? 150'000u
                                                     : n == 2 ? 400'000u
                                                     : n == 4 ? 1'000'000u
                                                              : 2'500'000u);
}

// The depth of the plane through the triangle's snapped corners, in doubles.
double exact_depth(const ScreenTriangle& t, GridPoint p) {
  const auto& [a, b, c] = t.corner;
  const auto cross = [](GridPoint from, GridPoint one, GridPoint other) {
    return static_cast<double>((one.x - from.x) * (other.y - from.y) - (other.x - from.x) * (one.y - from.y));
  };
  const double area = cross(a, b, c);
  return (cross(p, b, c) * static_cast<double>(t.z[0]) + cross(p, c, a) * static_cast<double>(t.z[1]) +
          cross(p, a, b) * static_cast<double>(t.z[2])) /
         area;
}

// Tilted triangles that pierce each other, slivers seen edge-on among them: which is nearest hangs on the bits of the
// depths, and those are the host's.
TEST_P(Coverage, DepthsAreThoseOfTheHostBitForBit) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(2000 + n);
  std::vector<ScreenTriangle> triangles = random_triangles(numbers, {2000, 500, 300, 300, 6, 6, 0}, n);
  for (ScreenTriangle& t : triangles)
    for (float& z : t.z) z = static_cast<float>(numbers.real(0.001, 0.999));
  FrontendRun run(device, screen_capture(triangles, kSide, kSide), kSide, kSide, n);
  run.run();
  const Wrong wrong = wrong_samples(run);
  EXPECT_EQ(wrong.triangle, 0u);
  EXPECT_EQ(wrong.depth, 0u);

  // The plane itself is float32 around the pixel nearest to the triangle's middle; slivers have steep ones.
  std::vector<const SetUpTriangle*> of_record;
  for (const SetUpTriangle& t : run.triangles) {
    if (t.record >= of_record.size()) of_record.resize(t.record + 1);
    of_record[t.record] = &t;
  }
  double largest = 0, of_rounding = 0;
  for (std::int64_t py = 0; py < kSide; ++py)
    for (std::int64_t px = 0; px < kSide; ++px)
      for (std::uint32_t s = 0; s < n; ++s) {
        const VisibleSample& seen = run.seen()[run.place(px, py, s)];
        if (seen.triangle == SUBPIXEL_NO_TRIANGLE || of_record[seen.triangle]->piece) continue;
        const SetUpTriangle& t = *of_record[seen.triangle];
        const double error = std::abs(exact_depth(triangles[t.source], sample_point(px, py, n, s)) -
                                      static_cast<double>(std::bit_cast<float>(seen.depth_bits)));
        largest = std::max(largest, error);
        of_rounding = std::max(of_rounding, error / t.depth_rounding(px, py));
      }
  fmt::print(
      "{:2} samples: {} depths, {} of other bits than the host's; off the exact plane by up to {:.1e}, {:.2f} of what "
      "rounding explains\n",
      n, run.seen().size(), wrong.depth, largest, of_rounding);
  EXPECT_LT(of_rounding, 1.0);
}

INSTANTIATE_TEST_SUITE_P(Samples, Coverage, testing::Values(1u, 2u, 4u, 8u, 16u, 32u, 64u));

}  // namespace
}  // namespace subpixel::replay
