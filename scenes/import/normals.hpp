// Normals that a model file lacks. A normal of length 0 or with a component that is not finite is lacking, too.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/builder/mesh.hpp"

namespace subpixel::capture {

// Edges between faces that turn by more are hard where the file says nothing: a prism of eight sides has hard edges,
// a tube of ten is round.
inline constexpr double kCreaseDegrees = 40;

// The same where the file says that faces are smooth. Many exporters put all faces of an object into one smoothing
// group, whose right angles are not meant to be round; a tube of six sides is.
inline constexpr double kGroupCreaseDegrees = 70;

// Of one triangle: 0 is none (flat), equal ones are smooth across edges of up to kGroupCreaseDegrees.
using SmoothingGroup = std::uint32_t;
inline constexpr SmoothingGroup kByCreaseAngle = 0xffffffffu;

// Gives every vertex the normal of its triangle. A vertex whose triangles lie in different planes is split; its copies
// follow the mesh's vertices, which keep their numbers, with all other attributes. Returns for each vertex of the new
// mesh the number of the old one, so that the caller can copy what it keeps beside the mesh.
std::vector<std::uint32_t> make_flat_normals(Mesh& mesh);

// Gives vertices that lack a normal one, and makes all others of length 1. A new normal is the mean, weighted by the
// angle at the corner (Thuermer and Wuethrich 1998), of the triangles reached around the vertex over edges that are
// smooth: by kCreaseDegrees, or by `groups` when it is not empty (one for each triangle; kByCreaseAngle: by the angle).
// Triangles are neighbours where positions are equal, whatever their other attributes. Splits and returns as above.
std::vector<std::uint32_t> make_missing_normals(Mesh& mesh, std::span<const SmoothingGroup> groups = {});

}  // namespace subpixel::capture
