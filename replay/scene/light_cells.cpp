#include "replay/scene/light_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kBitsOfWord = 32;
constexpr std::uint32_t kColumns = 32, kRows = 16, kMostSlices = 32;
// With more words a cell has, tiles are twice as wide and high.
constexpr std::uint32_t kMostWordsOfSmallTiles = 8;
static_assert(kColumns * kRows * kMostSlices * kMostWordsOfSmallTiles <= kMostLightWords);
static_assert(kColumns / 2 * kRows / 2 * kMostSlices * SUBPIXEL_MAX_POINT_LIGHTS / kBitsOfWord <= kMostLightWords);

// A depth's place in the order of floats, four to an octave; all that is not before the viewer has the lowest.
std::uint32_t depth_key(double depth) {
  using Limits = std::numeric_limits<float>;
  const double in_range = std::clamp<double>(depth, Limits::min(), Limits::max());
  return std::bit_cast<std::uint32_t>(static_cast<float>(in_range)) >> LIGHT_SLICE_SHIFT;
}

// What rounding to floats may add to a light's reach, as a part of it, and to a row's product with a point, as a part
// of its largest term.
constexpr double kReachSlack = 1e-4, kRounding = 16.0 * std::numeric_limits<float>::epsilon();

struct Interval {
  double low = 0, high = 0;
};

double reach_of(const gpu_types::PointLightConstants& light) {
  return static_cast<double>(light.position_range.w) * (1 + kReachSlack);
}

// What a row's product with a point in the light may be off by.
double rounding_of(const glm::dvec4& row, const gpu_types::PointLightConstants& light) {
  const glm::dvec3 farthest = glm::abs(glm::dvec3(light.position_range)) + reach_of(light);
  return kRounding * (glm::dot(glm::abs(glm::dvec3(row)), farthest) + std::abs(row.w));
}

// A row's product with the points in the light.
Interval row_over(const glm::dvec4& row, const gpu_types::PointLightConstants& light, double rounding) {
  const double middle = glm::dot(glm::dvec3(row), glm::dvec3(light.position_range)) + row.w;
  const double half = glm::length(glm::dvec3(row)) * reach_of(light) + rounding;
  return {middle - half, middle + half};
}

struct Range {
  std::uint32_t first = 0, last = 0;
};

// Tiles along an axis that points in the light and before the viewer may lie in. The first and the last tile have no
// outer border.
Range tiles_over(const glm::dvec4& row, const glm::dvec4& depth, std::uint32_t tiles,
                 const gpu_types::PointLightConstants& light) {
  const double row_rounding = rounding_of(row, light), depth_rounding = rounding_of(depth, light);
  // How far beyond the border before tile `border` the light's points lie.
  const auto beyond = [&](std::uint32_t border) {
    return row_over(row - static_cast<double>(border) * depth, light, row_rounding + border * depth_rounding);
  };
  Range range{0, tiles - 1};
  while (range.first < tiles - 1 && beyond(range.first + 1).low > 0) ++range.first;
  while (range.last > range.first && beyond(range.last).high < 0) --range.last;
  return range;
}

Range slices_over(const gpu_types::LightCellConstants& cells, const Interval& depth) {
  const auto slice = [&](double w) {
    const std::uint32_t key = depth_key(w);
    return std::min(key - std::min(key, cells.slices.x), cells.slices.y);
  };
  return {slice(depth.low), slice(depth.high)};
}

std::uint32_t words_of(std::size_t lights) {
  return static_cast<std::uint32_t>((lights + kBitsOfWord - 1) / kBitsOfWord);
}

void add_light(LightCells& cells, std::size_t cell, std::size_t light) {
  cells.lights[cell * cells.constants.slices.z + light / kBitsOfWord] |= 1u << light % kBitsOfWord;
}

}  // namespace

LightCells light_cells(std::span<const gpu_types::PointLightConstants> lights, const glm::mat4& world_to_clip) {
  LightCells result;
  gpu_types::LightCellConstants& cells = result.constants;
  const std::uint32_t words = words_of(lights.size());
  const std::uint32_t divide = words > kMostWordsOfSmallTiles ? 2 : 1;
  const std::uint32_t columns = kColumns / divide, rows = kRows / divide;
  const glm::mat4 by_row = glm::transpose(world_to_clip);
  cells.rows[0] = (by_row[0] + by_row[3]) * (0.5f * static_cast<float>(columns));
  cells.rows[1] = (by_row[1] + by_row[3]) * (0.5f * static_cast<float>(rows));
  cells.rows[2] = by_row[3];

  std::vector<Interval> depths;
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (const auto& light : lights) {
    const glm::dvec4 row(cells.rows[2]);
    depths.push_back(row_over(row, light, rounding_of(row, light)));
    nearest = std::min(nearest, depths.back().low);
    farthest = std::max(farthest, depths.back().high);
  }
  // The last slice holds all that is farther, the first one, before all lights where there is room, all that is nearer
  // or behind the viewer.
  const std::uint32_t last_key = depth_key(farthest), nearest_key = depth_key(std::min(nearest, farthest));
  const std::uint32_t slices = std::min(last_key - nearest_key + 2, kMostSlices);
  cells.slices = {last_key + 1 - slices, slices - 1, words, columns * rows};
  cells.tiles = {static_cast<float>(columns - 1), static_cast<float>(rows - 1), static_cast<float>(columns), 0};

  const std::size_t cell_count = std::size_t{columns} * rows * (cells.slices.y + 1);
  result.lights.assign(std::max<std::size_t>(cell_count * words, 1), 0);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Range x = tiles_over(cells.rows[0], cells.rows[2], columns, lights[i]);
    const Range y = tiles_over(cells.rows[1], cells.rows[2], rows, lights[i]);
    const Range z = slices_over(cells, depths[i]);
    for (std::uint32_t slice = z.first; slice <= z.last; ++slice) {
      // Of points behind the viewer columns and rows mean nothing.
      const bool all = slice == 0;
      for (std::uint32_t row = all ? 0 : y.first; row <= (all ? rows - 1 : y.last); ++row)
        for (std::uint32_t column = all ? 0 : x.first; column <= (all ? columns - 1 : x.last); ++column)
          add_light(result, std::size_t{slice * rows + row} * columns + column, i);
    }
  }
  return result;
}

LightCells one_light_cell(std::size_t lights) {
  LightCells result;
  result.constants.slices = {0, 0, words_of(lights), 1};
  result.constants.tiles = {0, 0, 1, 0};
  result.lights.assign(std::max(words_of(lights), 1u), 0);
  for (std::size_t i = 0; i < lights; ++i) add_light(result, 0, i);
  return result;
}

}  // namespace subpixel::replay
