// Shared edges: each sample of a mesh's interior is covered exactly once, on the host from set-up's records and on the
// device from its images, also where the mesh crosses the near plane and the guard band.
//
// On the device, "once" shows by drawing twice: of equal depths the first submitted stays, so a sample that two
// triangles of one depth cover shows another one when the order is reversed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "scenes/builder/camera.hpp"
#include "tests/technique/frontend_fixture.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kSide = 256;

// Inside a closed polygon by counting the edges to the right of the point, which is moved as ExactTriangle::covers
// says: right by an infinitesimal length, down by a smaller one.
class PolygonRow {
 public:
  PolygonRow(const std::vector<GridPoint>& polygon, std::int64_t y) : y_(y) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      GridPoint a = polygon[i], b = polygon[(i + 1) % polygon.size()];
      if (a.y > b.y) std::swap(a, b);
      if (a.y <= y && b.y > y) crossing_.emplace_back(a, b);
    }
  }
  bool inside(std::int64_t x) const {
    std::size_t right = 0;
    for (const auto& [a, b] : crossing_) {
      // Positive when the edge crosses the row to the right of the point; on it, the moved point is beyond.
      right += (b.x - a.x) * (y_ - a.y) - (x - a.x) * (b.y - a.y) > 0 ? 1 : 0;
    }
    return right % 2 == 1;
  }

 private:
  std::int64_t y_;
  std::vector<std::pair<GridPoint, GridPoint>> crossing_;  // upper end first
};

// How often set-up's records cover each sample: front faces, back faces.
struct Counts {
  std::vector<std::uint8_t> front, back;
};
Counts coverage_counts(const FrontendRun& run) {
  Counts counts{std::vector<std::uint8_t>(run.seen().size()), std::vector<std::uint8_t>(run.seen().size())};
  for (const SetUpTriangle& t : run.triangles) {
    auto& of_side = (t.data.v2_ref.w & RECORD_BACK_FACE) != 0 ? counts.back : counts.front;
    const PixelBox box = pixel_box(t.exact, run.width, run.height);
    for (std::int64_t py = box.y0; py < box.y1; ++py)
      for (std::int64_t px = box.x0; px < box.x1; ++px) {
        if (t.exact.misses_pixel(px, py)) continue;
        for (std::uint32_t s = 0; s < run.samples; ++s)
          if (t.exact.covers(sample_point(px, py, run.samples, s))) ++of_side[run.place(px, py, s)];
      }
  }
  return counts;
}

std::vector<ScreenTriangle> reversed(std::vector<ScreenTriangle> triangles) {
  std::reverse(triangles.begin(), triangles.end());
  return triangles;
}

// The source triangle seen at a sample, numbered as if nothing were reversed; -1 for none.
std::vector<std::int64_t> sources_seen(const FrontendRun& run, bool was_reversed, std::size_t count) {
  std::vector<std::int64_t> source_of(1);
  for (const auto& t : run.triangles) {
    if (t.record >= source_of.size()) source_of.resize(t.record + 1);
    source_of[t.record] = was_reversed ? static_cast<std::int64_t>(count) - 1 - t.source : t.source;
  }
  std::vector<std::int64_t> sources;
  for (const auto& sample : run.seen())
    sources.push_back(sample.triangle == SUBPIXEL_NO_TRIANGLE ? -1 : source_of.at(sample.triangle));
  return sources;
}

// A star-shaped polygon of needles around a point: its triangles meet in one corner and share an edge each.
struct Fan {
  std::vector<GridPoint> ring;
  std::vector<ScreenTriangle> triangles;
};
Fan random_fan(Numbers& numbers, int needles) {
  Fan fan;
  const GridPoint centre{numbers.whole(90 * 256, 166 * 256), numbers.whole(90 * 256, 166 * 256)};
  for (int i = 0; i < needles; ++i) {
    const double angle = 6.283185307179586 * i / needles, radius = 256 * numbers.real(30, 85);
    fan.ring.push_back(
        {centre.x + std::llround(radius * std::cos(angle)), centre.y + std::llround(radius * std::sin(angle))});
  }
  for (std::size_t i = 0; i < fan.ring.size(); ++i)
    fan.triangles.push_back({{centre, fan.ring[i], fan.ring[(i + 1) % fan.ring.size()]}, {0.5f, 0.5f, 0.5f}});
  return fan;
}

class Mesh : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Mesh, FanCoversEachSampleOnce) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(7 + n);
  std::uint64_t interior = 0, wrong_host = 0, wrong_device = 0;
  for (const int needles : {3, 40, 700}) {
    const Fan fan = random_fan(numbers, needles);
    FrontendRun run(device, screen_capture(fan.triangles, kSide, kSide), kSide, kSide, n);
    run.run();
    FrontendRun backwards(device, screen_capture(reversed(fan.triangles), kSide, kSide), kSide, kSide, n);
    backwards.run();
    const Counts counts = coverage_counts(run);
    const auto seen = sources_seen(run, false, fan.triangles.size());
    const auto seen_backwards = sources_seen(backwards, true, fan.triangles.size());
    for (std::int64_t py = 0; py < kSide; ++py)
      for (std::uint32_t s = 0; s < n; ++s) {
        const PolygonRow row(fan.ring, sample_point(0, py, n, s).y);
        for (std::int64_t px = 0; px < kSide; ++px) {
          const std::size_t i = run.place(px, py, s);
          const bool inside = row.inside(sample_point(px, py, n, s).x);
          interior += inside ? 1 : 0;
          wrong_host += counts.front[i] + counts.back[i] == (inside ? 1 : 0) ? 0 : 1;
          wrong_device += (seen[i] >= 0) == inside && seen[i] == seen_backwards[i] ? 0 : 1;
        }
      }
  }
  fmt::print("{:2} samples: {} inside fans, not once: {} on the host, {} on the device\n", n, interior, wrong_host,
             wrong_device);
  EXPECT_GT(interior, 10'000u);
  EXPECT_EQ(wrong_host, 0u);
  EXPECT_EQ(wrong_device, 0u);
}

// A sphere of latitude and longitude with its corners moved at random, squashed and turned: closed, with needles at its
// poles. Its coordinates go through the projection, so snapping moves every corner; that must move it alike in all its
// triangles.
std::vector<float> closed_mesh(Numbers& numbers, int columns, int rows, double roughness) {
  std::vector<glm::dvec3> corners;
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double polar = 3.141592653589793 * row / rows, around = 6.283185307179586 * column / columns;
      const double radius = row == 0 || row == rows ? 1 : numbers.real(1 - roughness, 1);
      const glm::dvec3 p{radius * std::sin(polar) * std::cos(around), 0.6 * radius * std::cos(polar),
                         radius * std::sin(polar) * std::sin(around)};
      corners.emplace_back(p.x * 0.8 - p.y * 0.6, p.x * 0.6 + p.y * 0.8, p.z);
    }
  std::vector<float> positions;
  const auto corner = [&](int row, int column) {
    // The poles are one corner each.
    const int which = row == 0 ? 0 : row == rows ? rows * columns : row * columns + column % columns;
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(corners[static_cast<std::size_t>(which)][k]));
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (row > 0) corner(row, column), corner(row, column + 1), corner(row + 1, column);
      if (row + 1 < rows) corner(row, column + 1), corner(row + 1, column + 1), corner(row + 1, column);
    }
  return positions;
}

std::vector<float> with_reversed_faces(std::vector<float> positions) {
  for (std::size_t t = 0; t < positions.size(); t += 9)
    std::swap_ranges(positions.begin() + static_cast<std::ptrdiff_t>(t) + 3,
                     positions.begin() + static_cast<std::ptrdiff_t>(t) + 6,
                     positions.begin() + static_cast<std::ptrdiff_t>(t) + 6);
  return positions;
}

TEST_P(Mesh, ClosedMeshHasAsManyFrontFacesAsBackFacesOverEverySample) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(70 + n);
  const std::uint32_t width = 160, height = 90;
  const glm::dmat4 projection = capture::perspective(40, 160.0 / 90.0, 0.1) * capture::translation({0.1, 0.05, -3.3});
  std::uint64_t once = 0, several = 0, unpaired = 0, more_than_once = 0, holes = 0;
  for (const double roughness : {0.0, 0.5}) {
    const std::vector<float> positions = closed_mesh(numbers, 200, 100, roughness);
    FrontendRun run(device, triangle_list_capture(positions, projection), width, height, n);
    run.run();
    const Counts counts = coverage_counts(run);
    // One-sided, the device draws the front faces alone, then the back faces alone.
    const auto one_sided = [&](const std::vector<float>& corners) {
      capture::Capture capture = triangle_list_capture(corners, projection);
      capture.materials[0].two_sided = false;
      return capture;
    };
    FrontendRun front(device, one_sided(positions), width, height, n);
    front.run();
    FrontendRun back(device, one_sided(with_reversed_faces(positions)), width, height, n);
    back.run();
    for (std::size_t i = 0; i < counts.front.size(); ++i) {
      unpaired += counts.front[i] == counts.back[i] ? 0 : 1;
      once += counts.front[i] == 1 ? 1 : 0;
      several += counts.front[i] > 1 ? 1 : 0;
      const bool covered = counts.front[i] > 0;
      const auto seen = [i](const FrontendRun& of) { return of.seen()[i].triangle != SUBPIXEL_NO_TRIANGLE; };
      holes += covered == seen(run) && covered == seen(front) && covered == seen(back) ? 0 : 1;
    }
    // The smooth one is convex: once from the front, but where snapping has turned a needle at the outline over.
    if (roughness == 0) more_than_once = several;
  }
  fmt::print(
      "{:2} samples: {} covered once from the front, {} more often (convex mesh: {}); {} not as often from the back; "
      "{} "
      "differ on the device\n",
      n, once, several, more_than_once, unpaired, holes);
  EXPECT_GT(once, std::uint64_t{2000} * n);
  EXPECT_EQ(unpaired, 0u);
  EXPECT_EQ(holes, 0u);
  EXPECT_LE(more_than_once * 1000, once);
}

// An irregular triangulation of a plane, corners shared, given by its corners in [-1, 1]^2.
std::vector<glm::dvec2> irregular_grid(Numbers& numbers, int cells) {
  std::vector<glm::dvec2> corners;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) {
      const auto moved = [&](int at) {
        const double inner = at == 0 || at == cells ? 0.0 : numbers.real(-0.24, 0.24);
        return 2 * (at + inner) / cells - 1;
      };
      const double along = moved(x);
      corners.emplace_back(along, moved(y));
    }
  return corners;
}

template <typename Place>
std::vector<float> grid_positions(Numbers& numbers, const std::vector<glm::dvec2>& corners, int cells, Place place) {
  std::vector<float> positions;
  const auto put = [&](int x, int y) {
    const glm::dvec3 p = place(corners[static_cast<std::size_t>(y * (cells + 1) + x)]);
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(p[k]));
  };
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      if (numbers.whole(0, 1) == 0) {
        put(x, y), put(x + 1, y), put(x, y + 1);
        put(x + 1, y), put(x + 1, y + 1), put(x, y + 1);
      } else {
        put(x, y), put(x + 1, y), put(x + 1, y + 1);
        put(x, y), put(x + 1, y + 1), put(x, y + 1);
      }
    }
  return positions;
}

TEST_P(Mesh, ScreenFillingMeshLeavesNoHole) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(700 + n);
  const std::uint32_t width = 160, height = 90;
  const glm::dmat4 projection = capture::perspective(60, 160.0 / 90.0, 0.1);
  for (const int cells : {3, 17, 220}) {
    const auto corners = irregular_grid(numbers, cells);
    // A tilted wall that is larger than the view.
    const auto positions = grid_positions(numbers, corners, cells, [](glm::dvec2 p) {
      return glm::dvec3(10 * p.x, 7 * p.y, -4 + 1.5 * p.x - 0.7 * p.y);
    });
    FrontendRun run(device, triangle_list_capture(positions, projection), width, height, n);
    run.run();
    const Counts counts = coverage_counts(run);
    std::uint64_t holes = 0, not_once = 0;
    for (std::size_t i = 0; i < counts.front.size(); ++i) {
      holes += run.seen()[i].triangle == SUBPIXEL_NO_TRIANGLE ? 1 : 0;
      not_once += counts.front[i] + counts.back[i] == 1 ? 0 : 1;
    }
    EXPECT_EQ(holes, 0u) << cells << " cells";
    EXPECT_EQ(not_once, 0u) << cells << " cells";
    EXPECT_EQ(run.frontend.clipped_count(), 0u);
  }
}

// A floor from behind the eye to far away and far to the sides: its triangles cross the near plane and the guard band,
// some with a corner behind the eye. The image shows nothing else.
TEST_P(Mesh, ClippedMeshLeavesNoHole) {
  const std::uint32_t n = GetParam();
  gpu::Device device;
  Numbers numbers(7000 + n);
  const std::uint32_t width = 160, height = 90;
  // Looking down by 40 degrees: the horizon is above the image, the near plane's edge just below it.
  const glm::dmat4 projection = capture::perspective(60, 160.0 / 90.0, 0.1) * capture::rotation({1, 0, 0}, 0.7);
  for (const int cells : {1, 2, 9, 41, 120}) {
    const auto corners = irregular_grid(numbers, cells);
    // Small cells near the eye and large ones far away.
    const auto positions = grid_positions(numbers, corners, cells, [](glm::dvec2 p) {
      return glm::dvec3(400 * std::pow(p.x, 5), -0.12, 400 * std::pow(p.y, 5) + 0.05);
    });
    FrontendRun run(device, triangle_list_capture(positions, projection), width, height, n);
    run.run();
    const Counts counts = coverage_counts(run);
    std::uint64_t holes = 0, not_once = 0;
    for (std::size_t i = 0; i < counts.front.size(); ++i) {
      holes += run.seen()[i].triangle == SUBPIXEL_NO_TRIANGLE ? 1 : 0;
      not_once += counts.front[i] + counts.back[i] == 1 ? 0 : 1;
    }
    if (n == 8)
      fmt::print("{} cells: {} triangles clipped into {} hulls\n", cells, run.frontend.clipped_count(),
                 run.frontend.hull_count());
    EXPECT_GT(run.frontend.clipped_count(), 0u);
    EXPECT_EQ(holes, 0u) << cells << " cells";
    EXPECT_EQ(not_once, 0u) << cells << " cells";
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, Mesh, testing::Values(1u, 8u, 64u));

// Triangles that reach up to 32 times as far as the guard band, against themselves unclipped in exact arithmetic.
// Clipping makes corners on the guard band, in floats and then snapped, which turns the edges by up to a grid unit
// within the image.
TEST(Clipping, MovesEdgesByLessThanTwoGridUnits) {
  gpu::Device device;
  Numbers numbers(31);
  constexpr std::uint32_t kSamples = 16;
  constexpr std::int64_t kGuard = 256 * SUBPIXEL_GUARD_BAND_PX;
  std::uint64_t covered = 0, moved = 0, wrong = 0;
  for (int round = 0; round < 40; ++round) {
    const double angle = numbers.real(0, 6.283185307179586);
    const GridPoint through{numbers.whole(0, 256 * kSide), numbers.whole(0, 256 * kSide)};
    const auto at = [&](double direction) {
      const double distance = static_cast<double>(kGuard) * std::exp2(numbers.real(0.5, 5));
      return GridPoint{through.x + std::llround(distance * std::cos(direction)),
                       through.y + std::llround(distance * std::sin(direction))};
    };
    ScreenTriangle t;
    t.corner[0] = at(angle);
    t.corner[1] = at(angle + 3.141592653589793 + numbers.real(-0.01, 0.01));
    t.corner[2] = at(angle + 1.5707963267948966 + numbers.real(-1, 1));
    FrontendRun run(device, screen_capture({t}, kSide, kSide), kSide, kSide, kSamples);
    run.run();
    const ExactTriangle exact(t.corner[0], t.corner[1], t.corner[2]);
    for (std::int64_t py = 0; py < kSide; ++py)
      for (std::int64_t px = 0; px < kSide; ++px)
        for (std::uint32_t s = 0; s < kSamples; ++s) {
          const GridPoint p = sample_point(px, py, kSamples, s);
          const bool seen = run.seen()[run.place(px, py, s)].triangle != SUBPIXEL_NO_TRIANGLE;
          covered += seen ? 1 : 0;
          if (seen == exact.covers(p)) continue;
          ++moved;
          wrong += exact.distance_to_edges(p) > 2 ? 1 : 0;
        }
  }
  fmt::print(
      "{} samples covered, {} decided otherwise than without clipping, {} of them over two grid units from an edge\n",
      covered, moved, wrong);
  EXPECT_GT(covered, 1'000'000u);
  EXPECT_EQ(wrong, 0u);
  EXPECT_LE(moved * 1000, covered);
}

}  // namespace
}  // namespace subpixel::replay
