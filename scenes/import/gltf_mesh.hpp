// Primitives of a glTF mesh: their attributes read once, then turned into triangle meshes as they are posed
// (sections 3.7.2 and 3.7.3, KHR_draco_mesh_compression, KHR_mesh_quantization). Private to gltf.cpp.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/builder/mesh.hpp"
#include "scenes/import/gltf_document.hpp"
#include "scenes/import/gltf_materials.hpp"

namespace subpixel::capture {

struct MorphTarget {
  std::vector<glm::dvec3> positions, normals, tangents;  // differences; empty or one for each vertex
};

struct GltfPrimitive {
  std::string name;
  std::string path;  // in the document, for messages
  std::optional<std::size_t> material;
  Mesh mesh;  // as stored; normals, tangents and UVs may be missing
  std::vector<MorphTarget> targets;
  struct Influence {
    std::uint32_t joint;
    double weight;
  };
  std::vector<Influence> influences;  // `influences_per_vertex` for each vertex, weights adding up to 1
  std::size_t influences_per_vertex = 0;
};

// Primitive `from` of a mesh. UVs are those of the material's sets, its baked transform applied. Nothing for points and
// lines.
std::optional<GltfPrimitive> read_primitive(const GltfDocument& document, const GltfElement& from,
                                            const GltfMaterial& material);

// The primitive with its targets weighted (missing weights: 0) and, with `joints` (world matrices times inverse bind
// matrices), its vertices moved to world space. Normals and, for a normal map, tangents are there.
Mesh posed(const GltfPrimitive& primitive, std::span<const double> weights, std::span<const glm::dmat4> joints,
           const Material& material);

}  // namespace subpixel::capture
