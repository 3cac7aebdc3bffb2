#include "scenes/builder/scene_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <utility>

namespace subpixel::capture {
namespace {

void put(std::vector<std::byte>& out, const auto& value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), from, from + sizeof value);
}

void put_floats(std::vector<std::byte>& out, const auto& vector) {
  for (int i = 0; i < vector.length(); ++i) put(out, static_cast<float>(vector[i]));
}

void put_snorm16x4(std::vector<std::byte>& out, const glm::dvec4& vector) {
  for (int i = 0; i < 4; ++i) put(out, static_cast<std::int16_t>(std::floor(vector[i] * 32767.0 + 0.5)));
}

void put_unorm16x4(std::vector<std::byte>& out, const glm::vec4& vector) {
  for (int i = 0; i < 4; ++i) put(out, static_cast<std::uint16_t>(std::floor(vector[i] * 65535.0f + 0.5f)));
}

}  // namespace

Draw SceneBuilder::add_mesh(const std::string& name, const Mesh& mesh) {
  const bool has_tangents = !mesh.tangents.empty();
  const bool has_uvs2 = !mesh.uvs2.empty();
  const bool has_colours = !mesh.colours.empty();
  const auto in_unit = [](const glm::vec4& c) { return glm::clamp(c, 0.0f, 1.0f) == c; };
  const bool small_colours = std::all_of(mesh.colours.begin(), mesh.colours.end(), in_unit);
  std::vector<std::byte> vertices;
  vertices.reserve(mesh.positions.size() * 36);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    put_floats(vertices, mesh.positions[i]);
    put_snorm16x4(vertices, glm::dvec4(mesh.normals[i], 0));
    put_floats(vertices, mesh.uvs[i]);
    if (has_tangents) put_snorm16x4(vertices, mesh.tangents[i]);
    if (has_uvs2) put_floats(vertices, mesh.uvs2[i]);
    if (has_colours && small_colours) put_unorm16x4(vertices, mesh.colours[i]);
    if (has_colours && !small_colours) put_floats(vertices, mesh.colours[i]);
  }
  std::vector<std::byte> indices;
  const bool small = mesh.positions.size() <= 65536;
  indices.reserve(mesh.indices.size() * (small ? 2 : 4));
  for (const std::uint32_t index : mesh.indices) {
    if (small) {
      put(indices, static_cast<std::uint16_t>(index));
    } else {
      put(indices, index);
    }
  }
  const std::uint32_t buffer = recorder_.add_buffer(name + " vertices", vertices);
  Draw draw;
  std::uint32_t stride = 0;
  std::vector<VertexStream*> present;
  const auto add = [&](VertexStream& stream, VertexFormat format, std::uint32_t bytes) {
    stream = {buffer, format, stride, 0};
    stride += bytes;
    present.push_back(&stream);
  };
  add(draw.position, VertexFormat::float32x3, 12);
  add(draw.normal, VertexFormat::snorm16x4, 8);
  add(draw.uv, VertexFormat::float32x2, 8);
  if (has_tangents) add(draw.tangent, VertexFormat::snorm16x4, 8);
  if (has_uvs2) add(draw.uv2, VertexFormat::float32x2, 8);
  if (has_colours && small_colours) add(draw.colour, VertexFormat::unorm16x4, 8);
  if (has_colours && !small_colours) add(draw.colour, VertexFormat::float32x4, 16);
  for (VertexStream* stream : present) stream->stride = stride;
  draw.vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
  draw.index_type = small ? IndexType::uint16 : IndexType::uint32;
  draw.index_buffer = recorder_.add_buffer(name + " indices", indices);
  draw.index_count = static_cast<std::uint32_t>(mesh.indices.size());
  return draw;
}

void SceneBuilder::draw(Draw mesh, const std::string& name, std::uint32_t material, const glm::dmat4& placement) {
  mesh.name = name;
  mesh.material = material;
  mesh.transform = to_matrix4(placement);
  draws_.push_back(std::move(mesh));
}

void SceneBuilder::draw_instances(Draw mesh, const std::string& name, std::uint32_t material,
                                  std::span<const glm::dmat4> placements) {
  if (placements.empty()) return;
  std::vector<std::byte> matrices;
  matrices.reserve(placements.size() * sizeof(Matrix4));
  for (const glm::dmat4& placement : placements) put(matrices, to_matrix4(placement));
  mesh.name = name;
  mesh.material = material;
  mesh.instance_buffer = recorder_.add_buffer(name + " placements", matrices);
  mesh.instance_count = static_cast<std::uint32_t>(placements.size());
  draws_.push_back(std::move(mesh));
}

void SceneBuilder::record_frame(Frame frame) {
  frame.draws.clear();
  recorder_.begin_frame(std::move(frame));
  for (const Draw& draw : draws_) recorder_.draw(draw);
  recorder_.end_frame();
}

Capture SceneBuilder::finish(const CameraPath& path, std::uint32_t frames, std::uint32_t width, std::uint32_t height,
                             double frames_per_second) {
  for (std::uint32_t i = 0; i < frames; ++i) {
    Frame frame = environment;
    frame.name = "frame " + std::to_string(i);
    path.set(frame, i / frames_per_second, width, height);
    record_frame(std::move(frame));
  }
  return take();
}

}  // namespace subpixel::capture
