// Meshes of all frames in one set of vertex and index arrays. Draws that read the same streams share the vertices, and
// draws that also read the same index range share the mesh, over all frames.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/scene/bounds.hpp"

namespace subpixel::replay {

struct DrawReference {
  std::uint32_t frame = 0, draw = 0;
};

// Vertices decoded once: the streams of `source`, all vertex_count of them.
struct VertexSet {
  DrawReference source;
  std::uint32_t first_vertex = 0, vertex_count = 0;
  // Without a normal stream glTF asks for flat shading: one vertex for each corner of each triangle.
  bool flat = false;
  // A normal map needs tangents and the stream is absent: made from positions, normals and the uvs it is read by.
  bool make_tangents = false;
};

struct Mesh {
  DrawReference source;  // whose index range
  std::uint32_t vertex_set = 0;
  std::uint32_t first_index = 0, triangle_count = 0;
};

// What of the optional streams the scene's shaders read.
struct VertexNeeds {
  bool uvs = false, tangents = false, second_uvs = false, colours = false;
};

// Texture coordinates beyond this count as 0, like NaN.
inline constexpr float kLargestUv = 1e6f;

struct GeometryPlan {
  VertexNeeds needs;
  std::vector<VertexSet> vertex_sets;
  std::vector<Mesh> meshes;
  std::vector<std::vector<std::uint32_t>> mesh_of_draw;  // [frame][draw]
  std::uint32_t vertex_count = 0;
  std::uint64_t index_count = 0;
};

// Throws DeviceError when the vertices or indices of all frames together exceed what 32-bit numbers address.
GeometryPlan plan_geometry(const capture::Capture& capture, VertexNeeds needs);

// Where the arrays go, sized by the plan: 3, 3, 2, 4, 2 and 4 floats a vertex. Those not needed may be empty.
struct GeometryArrays {
  std::span<float> positions, normals, uvs, tangents;
  std::span<std::uint32_t> indices;
  std::span<float> second_uvs{}, colours{};
};

// Decodes every vertex set and mesh. Positions are as captured, NaN included; normals come out unit, uvs finite,
// tangents finite, absent ones 0, and colours finite and not negative, absent ones 1. Returns the object-space bounds
// of each mesh.
std::vector<Bounds> fill_geometry(const capture::Capture& capture, const GeometryPlan& plan,
                                  const GeometryArrays& arrays);

}  // namespace subpixel::replay
