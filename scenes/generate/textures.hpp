// Textures computed for the procedural scenes: rgba8, tileable unless said otherwise. Colours are sRGB values in 0 to
// 255 and mixed as such, for the transfer function's pow() would differ between machines.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Value noise in [0, 1] that repeats after `period` units in both directions; several octaves, each half as strong.
double tileable_noise(double x, double y, std::uint32_t period, std::uint32_t octaves, std::uint64_t seed);

// A mix of two colours by noise with `cells` noise cells along a side.
Texture noise_texture(std::string name, std::uint32_t side, std::uint32_t cells, const glm::dvec3& low,
                      const glm::dvec3& high, std::uint64_t seed);

struct BrickPattern {
  std::uint32_t columns = 4, rows = 8;  // rows even, as every second one is shifted by half a brick
  double shift = 0.5;                   // of odd rows, in bricks
  double mortar = 0.06;                 // width in bricks' heights
  glm::dvec3 brick{150, 84, 66}, brick_other{122, 62, 50}, joint{168, 162, 150};
  bool chequered = false;  // the two colours by turns rather than mixed from brick to brick
};

// Brick-work or paving, with the colour varying from brick to brick.
Texture brick_texture(std::string name, std::uint32_t side, const BrickPattern& pattern, std::uint64_t seed);

// The normal map of the same pattern and seed: rounded edges, joints lying `depth` (in sides of the texture) lower.
Texture brick_normal_texture(std::string name, std::uint32_t side, const BrickPattern& pattern, double depth,
                             std::uint64_t seed);

// Pieces of coloured glass between dark lead, `cells` along a side.
Texture stained_glass_texture(std::string name, std::uint32_t side, std::uint32_t cells, std::uint64_t seed);

// A gradient from root (v = 1, the bottom row) to tip with a lighter middle rib. Tileable in neither direction.
Texture blade_texture(std::string name, std::uint32_t width, std::uint32_t height, const glm::dvec3& root,
                      const glm::dvec3& tip);

// A twig of leaves with veins on transparent ground, its stem at the middle of the bottom edge. Colour bleeds into the
// transparent texels so that filtering brings no dark seams. Not tileable.
Texture leaf_texture(std::string name, std::uint32_t side, const glm::dvec3& leaf, std::uint64_t seed);

}  // namespace subpixel::capture
