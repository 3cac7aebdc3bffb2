// What several hard cases are put together from.
#pragma once

#include <glm/vec3.hpp>
#include <string>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::capture {

// An empty scene without light: the ambient term and the sky are black.
SceneBuilder dark_case(const std::string& name, const GenerateOptions& options);
// One with a sun from above the camera's left, without shadows, a little ambient light and a blue sky.
SceneBuilder lit_case(const std::string& name, const GenerateOptions& options);

// Shows `radiance` from everywhere and reflects nothing where only emission lights the scene.
std::uint32_t add_emitting(SceneBuilder& scene, const std::string& name, const Float3& radiance);

// At (0, 0, distance), looking at the origin, 45 degrees high, drifting by a few pixels in a second.
CameraPath case_camera(double distance);
// Side of a pixel of that camera's frame at `distance` from it.
double pixel_side(double distance, const GenerateOptions& options);

// A flat strip of constant width from `from` to `to`, seen from +z.
void add_strip(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double width);

}  // namespace subpixel::capture
