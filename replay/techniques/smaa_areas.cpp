#include "replay/techniques/smaa_areas.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "shaders/techniques/smaa/smaa_interface.h"

namespace subpixel::replay {
namespace {

// Half a pixel to the side of what crosses, where the line begins or ends: y up, 0 on the edge.
constexpr double kBefore = 0.5, kAfter = -0.5;

// Of the segment from (x0, y0) to (x1, y1), within x and x + 1: the areas below and above the axis y = 0.
glm::dvec2 areas_within(double x, double x0, double y0, double x1, double y1) {
  const double from = std::clamp(x, x0, x1), to = std::clamp(x + 1, x0, x1);
  if (from >= to) return {0, 0};
  const double slope = (y1 - y0) / (x1 - x0), a = y0 + slope * (from - x0), b = y0 + slope * (to - x0);
  const double width = to - from;
  if (a * b >= 0) {
    const double area = width * std::abs(a + b) / 2;
    return a + b < 0 ? glm::dvec2(area, 0) : glm::dvec2(0, area);
  }
  // Two triangles, which meet where the segment crosses the axis.
  const double first = width * a * a / std::abs(a - b) / 2, second = width * b * b / std::abs(a - b) / 2;
  return a < 0 ? glm::dvec2(first, second) : glm::dvec2(second, first);
}

// Short edges that turn to the same side at both ends are smoothed more (the authors' code): by the square root of the
// area, less and less so up to 32 pixels.
glm::dvec2 smoothed(const glm::dvec2& areas, double length) {
  return glm::mix(glm::sqrt(areas * 2.0) * 0.5, areas, std::min(length / 32, 1.0));
}

bool single(SmaaCrossing crossing) {
  return crossing == SMAA_CROSSED_BEFORE || crossing == SMAA_CROSSED_AFTER;
}

// The part of the unit square at `corner` below the line from `p` to `q`, which goes up or to the right.
double share_below(const glm::dvec2& corner, const glm::dvec2& p, const glm::dvec2& q) {
  if (q.x == p.x) return std::clamp(corner.x + 1 - p.x, 0.0, 1.0);
  // The line's height over the square's lower side, clamped to the square, is linear between these places.
  const double slope = (q.y - p.y) / (q.x - p.x);
  const auto height = [&](double x) { return std::clamp(p.y + slope * (x - p.x) - corner.y, 0.0, 1.0); };
  std::array<double, 4> places{corner.x, corner.x + 1, corner.x, corner.x};
  if (slope != 0) {
    for (int k = 0; k < 2; ++k)
      places.at(2 + static_cast<std::size_t>(k)) =
          std::clamp(p.x + (corner.y + k - p.y) / slope, corner.x, corner.x + 1);
  }
  std::ranges::sort(places);
  double area = 0;
  for (std::size_t i = 0; i + 1 < places.size(); ++i)
    area += (places[i + 1] - places[i]) * (height(places[i]) + height(places[i + 1])) / 2;
  return area;
}

}  // namespace

glm::dvec2 smaa_line_areas(SmaaCrossing before, SmaaCrossing after, glm::dvec2 distances) {
  constexpr SmaaCrossing kBoth = SMAA_CROSSED_BEFORE | SMAA_CROSSED_AFTER;
  // What crosses on both sides turns away from the other end, if that is known.
  if (before == kBoth) before = single(after) ? kBoth ^ after : 0;
  if (after == kBoth) after = single(before) ? kBoth ^ before : 0;
  const double length = distances.x + distances.y + 1, x = distances.x;
  const double begin = before == SMAA_CROSSED_BEFORE ? kBefore : kAfter;
  const double end = after == SMAA_CROSSED_BEFORE ? kBefore : kAfter;
  if (single(before) && single(after) && before != after) return areas_within(x, 0, begin, length, end);
  const glm::dvec2 first = areas_within(x, 0, begin, length / 2, 0);
  const glm::dvec2 second = areas_within(x, length / 2, 0, length, end);
  if (single(before) && single(after)) return smoothed(first, length) + smoothed(second, length);
  // A line that is known at one end only is the edge itself from the middle on.
  if (single(before)) return distances.x <= distances.y ? first : glm::dvec2(0);
  if (single(after)) return distances.x >= distances.y ? second : glm::dvec2(0);
  return {0, 0};
}

glm::dvec2 smaa_diagonal_areas(SmaaCrossing before, SmaaCrossing after, glm::dvec2 distances) {
  // The corners of the first step that the line may begin at, and of the last one that it may end at. Where both edges
  // go on or neither does, either may be meant, and the areas are means (the authors' code).
  static constexpr std::array<std::array<glm::dvec2, 2>, 4> kCorners{{
      {glm::dvec2(0, 0), glm::dvec2(1, 0)},
      {glm::dvec2(1, 0), glm::dvec2(1, 0)},
      {glm::dvec2(1, 1), glm::dvec2(1, 1)},
      {glm::dvec2(1, 1), glm::dvec2(1, 0)},
  }};
  constexpr std::array<std::uint32_t, 4> kAtEnd{0, 2, 1, 3};
  const double length = distances.x + distances.y + 1;
  const glm::dvec2 step(distances.x);
  glm::dvec2 areas(0);
  for (std::size_t which = 0; which < 2; ++which) {
    const glm::dvec2 p = kCorners.at(before).at(which);
    const glm::dvec2 q = kCorners.at(kAtEnd.at(after)).at(which) + length;
    if (p == q) continue;  // of a single step, which no staircase is
    areas +=
        glm::dvec2(1 - share_below(step + glm::dvec2(1, 0), p, q), share_below(step + glm::dvec2(1, 1), p, q)) / 2.0;
  }
  return areas;
}

std::vector<glm::vec2> smaa_area_table() {
  std::vector<glm::vec2> table;
  for (SmaaCrossing pattern = 0; pattern < 16; ++pattern)
    for (int x = 0; x < SMAA_AREA_DISTANCES; ++x)
      for (int y = 0; y < SMAA_AREA_DISTANCES; ++y)
        table.emplace_back(smaa_line_areas(pattern / 4, pattern % 4, glm::dvec2(x * x, y * y)));
  for (SmaaCrossing pattern = 0; pattern < 16; ++pattern)
    for (int x = 0; x < SMAA_DIAGONAL_DISTANCES; ++x)
      for (int y = 0; y < SMAA_DIAGONAL_DISTANCES; ++y)
        table.emplace_back(smaa_diagonal_areas(pattern / 4, pattern % 4, glm::dvec2(x, y)));
  return table;
}

}  // namespace subpixel::replay
