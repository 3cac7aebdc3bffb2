// Blades of grass: for the grass field and for the lawns of imported scenes.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/random.hpp"

namespace subpixel::capture {

struct BladeShape {
  std::uint32_t segments = 4;  // along its length: two triangles each, one for the tip's
  double height_m = 0.42;      // 60% to 140% of it
  double width_m = 0.011;      // at the root, 70% to 130% of it
  double patch_m = 0.5;        // roots stand in a square of this side around the origin
};

// Adds one blade, bent to a random side, to the patch `mesh`. uv: u across, v = 1 at the root.
void add_blade(Mesh& mesh, const BladeShape& shape, Random& random);

// A two-sided material with a gradient between two sRGB colours (0 to 255) along the blade.
std::uint32_t add_grass_material(SceneBuilder& scene, const std::string& name, const glm::dvec3& root,
                                 const glm::dvec3& tip);

}  // namespace subpixel::capture
