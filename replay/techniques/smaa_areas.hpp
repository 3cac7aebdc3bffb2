// The areas that SMAA's weights are: between an edge of pixels and the line that its pattern stands for.
// Jimenez, Echevarria, Sousa and Gutierrez 2012, "SMAA: Enhanced Subpixel Morphological Antialiasing"; which pattern
// stands for which line is that of the authors' public code (github.com/iryoku/smaa) where the text leaves it open.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace subpixel::replay {

// What crosses an edge at one of its ends: SMAA_CROSSED_ bits of shaders/techniques/smaa/smaa_interface.h.
using SmaaCrossing = std::uint32_t;

// Of a pixel of a level or upright edge with `distances` pixels before and after it on the edge: the share that the
// pixel takes from its neighbour across the edge, and that the neighbour takes from it.
glm::dvec2 smaa_line_areas(SmaaCrossing before, SmaaCrossing after, glm::dvec2 distances);

// The same of a staircase of steps of one pixel. A crossing is 2 where the level edge goes on at that end, 1 where the
// upright one does, 3 both, 0 neither.
glm::dvec2 smaa_diagonal_areas(SmaaCrossing before, SmaaCrossing after, glm::dvec2 distances);

// The table of the shaders: [before][after][distance before][distance after], first of lines at squared distances, then
// of diagonals.
std::vector<glm::vec2> smaa_area_table();

}  // namespace subpixel::replay
