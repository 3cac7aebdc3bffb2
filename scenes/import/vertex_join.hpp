// Vertices that are equal in every attribute, made one.
#pragma once

#include "scenes/builder/mesh.hpp"

namespace subpixel::capture {

// Keeps the first of equal vertices, in the order in which the triangles use them; those that no triangle uses go.
// Equal is by value, not within a distance: a model may be small.
void join_equal_vertices(Mesh& mesh);

}  // namespace subpixel::capture
