// Tangents for normal maps where the capture has none.
#pragma once

#include <cstdint>
#include <vector>

namespace subpixel::replay {

// Four floats a vertex: the unit direction of growing u, made perpendicular to the normal, and the bitangent's sign
// such that bitangent = cross(normal, tangent) * sign grows along -v, as glTF has it. The triangles' uv gradients are
// summed weighted by area (Lengyel, "Foundations of Game Engine Development 2", section 7.5). A vertex without uvs,
// or whose uvs don't span an area, gets zeros. Arrays of 3, 3 and 2 floats a vertex; `triangles` has corner numbers.
std::vector<float> tangents_from_uvs(const std::vector<float>& positions, const std::vector<float>& normals,
                                     const std::vector<float>& uvs, const std::vector<std::uint32_t>& triangles);

}  // namespace subpixel::replay
