// Which point lights may reach a point: for shaders, a bit for each light and cell of the view's volume. A point
// light's window is 0 from its range on, so lights that a cell leaves out would add nothing, and images keep their
// bits. Clusters after Olsson, Billeter and Assarsson 2012, "Clustered deferred and forward shading": tiles of the
// screen, divided in depth so that each slice is as deep as it is far.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "shaders/include/shared_types.h"

namespace subpixel::replay {

struct LightCells {
  gpu_types::LightCellConstants constants{};
  // constants.slices.z for each cell; cells by slice, row, column. Light i: bit i % 32 of word i / 32.
  std::vector<std::uint32_t> lights;
};

// Words of LightCells::lights, at most, however many lights there are.
inline constexpr std::size_t kMostLightWords = std::size_t{1} << 17;

// Cells of the volume that `world_to_clip` (without jitter) sees; points outside of it have a cell, too, so that every
// point with finite coordinates finds all lights that reach it. One cell without lights where there are none.
LightCells light_cells(std::span<const gpu_types::PointLightConstants> lights, const glm::mat4& world_to_clip);

// One cell for all points, with all lights.
LightCells one_light_cell(std::size_t lights);

}  // namespace subpixel::replay
