// Small things several procedural scenes need.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

inline constexpr std::uint32_t kSceneLights = 32;  // the papers have 5, 16, 32 and 50

// A count times the options' density, at least 1.
std::uint32_t scaled_count(std::uint32_t count, double density);

// first, first + step, ... up to `last`.
std::vector<double> every(double first, double step, double last);

// A material without textures. Colours are linear.
std::uint32_t add_plain_material(SceneBuilder& scene, const std::string& name, const glm::dvec3& colour,
                                 double roughness, double metallic = 0);

// The glass of a lamp that is on: `emissive` in the scene's units of radiance, linear, as `colour` is.
std::uint32_t add_lamp_glass(SceneBuilder& scene, const glm::vec3& colour, const glm::vec3& emissive);

// Triangles of a grid of (rows + 1) x (columns + 1) vertices, row by row, that begins with the mesh's first vertex.
void add_grid_triangles(Mesh& mesh, std::uint32_t rows, std::uint32_t columns);

// A ground of 120 m x 120 m at y = 0 with a noise texture that repeats after `tile_m`. Colours are sRGB, 0 to 255.
void draw_floor(SceneBuilder& scene, const std::string& name, const glm::dvec3& low, const glm::dvec3& high,
                double tile_m, double roughness, std::uint64_t seed);

// kSceneLights point lights at random in a box, warm to cold.
void scatter_lights(SceneBuilder& scene, const glm::dvec3& low, const glm::dvec3& high, double intensity, double range,
                    Random& random);

// The wall over one bay from pier to pier with a round opening, `thickness` around x = 0, z from 0 to -bay, from the
// opening's springing to `top`. Smooth inside the opening; uv in metres.
struct ArchShape {
  double bay, radius, springing, top, thickness;
  std::uint32_t steps = 24;  // around the half circle
};
Mesh arched_wall(const ArchShape& shape);

// A box whose uv are in metres times `uv_scale`, with tangents.
Mesh boxed(const glm::dvec3& low, const glm::dvec3& high, double uv_scale);

// A two-coloured pattern with its normal map.
std::uint32_t add_masonry(SceneBuilder& scene, const std::string& name, const BrickPattern& pattern, double depth,
                          float roughness, std::uint64_t seed);

// Some direction, uniform on the sphere.
glm::dvec3 random_direction(Random& random);

}  // namespace subpixel::capture
