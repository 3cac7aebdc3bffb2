#include "replay/scene/geometry.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <unordered_map>

#include "base/error.hpp"
#include "capture_format/streams.hpp"
#include "replay/scene/materials.hpp"
#include "replay/scene/tangents.hpp"

namespace subpixel::replay {
namespace {

using Key = std::array<std::uint64_t, 28>;
struct KeyHash {
  std::size_t operator()(const Key& key) const { return XXH3_64bits(key.data(), sizeof key); }
};

const capture::Draw& draw_of(const capture::Capture& capture, DrawReference at) {
  return capture.frames[at.frame].draws[at.draw];
}

// The stream's identity at `key`; absent streams of any leftover format and offset are one.
void put_stream(Key& key, std::size_t at, const capture::VertexStream& stream, bool needed) {
  const bool present = needed && stream.buffer != capture::kNone;
  key[at] = present ? (std::uint64_t{stream.buffer} << 32 | static_cast<std::uint32_t>(stream.format)) : ~0ull;
  key[at + 1] = present ? stream.offset : 0;
  key[at + 2] = present ? stream.stride : 0;
}

void put_indices(Key& key, std::size_t at, const capture::Draw& draw) {
  const bool indexed = draw.index_type != capture::IndexType::none;
  key[at] = indexed ? (std::uint64_t{draw.index_buffer} << 32 | static_cast<std::uint32_t>(draw.index_type)) : ~0ull;
  key[at + 1] = indexed ? draw.index_offset : 0;
  key[at + 2] = draw.index_count;
  key[at + 3] = static_cast<std::uint64_t>(static_cast<std::int64_t>(draw.base_vertex));
}

void put_mapping(Key& key, std::size_t at, const capture::UvMapping& mapping) {
  key[at] = mapping.set;
  for (std::size_t i = 0; i < mapping.matrix.size(); ++i)
    key[at + 1 + i / 2] |= std::uint64_t{std::bit_cast<std::uint32_t>(mapping.matrix[i])} << 32 * (i % 2);
}

// Unit, or the object's z axis for a vector without direction.
glm::vec3 unit(const glm::vec3& v) {
  const float scale = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(scale > 1e-30f && scale <= std::numeric_limits<float>::max())) return {0, 0, 1};
  const glm::vec3 scaled = v / scale;
  return scaled / std::sqrt(glm::dot(scaled, scaled));
}

float finite_uv(float value) {
  return std::abs(value) <= kLargestUv ? value : 0.0f;
}

float finite_colour(float value) {
  return value > 0 && value <= 1e6f ? value : 0.0f;
}

glm::vec3 vec3_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// One vertex set in plain arrays, before it goes to its place.
struct DecodedSet {
  std::vector<float> positions, normals, uvs, tangents, second_uvs, colours;
};

// The coordinates that a texture with this mapping is read by.
std::vector<float> mapped_uvs(const DecodedSet& set, const capture::UvMapping& mapping) {
  std::vector<float> uvs = mapping.set == 0 ? set.uvs : set.second_uvs;
  const auto& m = mapping.matrix;
  for (std::size_t i = 0; i + 2 <= uvs.size(); i += 2) {
    const float u = uvs[i], v = uvs[i + 1];
    uvs[i] = m[0] * u + m[1] * v + m[2];
    uvs[i + 1] = m[3] * u + m[4] * v + m[5];
  }
  return uvs;
}

// Repeats elements of `width` floats in the order of `order`; an absent stream stays absent.
std::vector<float> expanded(const std::vector<float>& values, std::size_t width,
                            const std::vector<std::uint32_t>& order) {
  if (values.empty()) return {};
  std::vector<float> result;
  result.reserve(order.size() * width);
  for (const std::uint32_t i : order)
    result.insert(result.end(), values.begin() + static_cast<std::ptrdiff_t>(i * width),
                  values.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
  return result;
}

std::vector<float> flat_normals(const std::vector<float>& corners) {
  std::vector<float> normals(corners.size());
  for (std::size_t t = 0; t + 9 <= corners.size(); t += 9) {
    const glm::vec3 a = vec3_at(corners, t / 3), b = vec3_at(corners, t / 3 + 1), c = vec3_at(corners, t / 3 + 2);
    const glm::vec3 normal = unit(glm::cross(b - a, c - a));
    for (std::size_t corner = 0; corner < 3; ++corner)
      for (int i = 0; i < 3; ++i) normals[t + 3 * corner + static_cast<std::size_t>(i)] = normal[i];
  }
  return normals;
}

capture::UvMapping normal_mapping(const capture::Material& material) {
  return uv_mappings_of(material)[2];
}

DecodedSet decode(const capture::Capture& capture, const VertexSet& set, VertexNeeds needs) {
  const auto& draw = draw_of(capture, set.source);
  DecodedSet decoded;
  decoded.positions = capture::decode_stream(capture, draw.position, draw.vertex_count, 3);
  decoded.normals = capture::decode_stream(capture, draw.normal, draw.vertex_count, 3);
  if (needs.uvs) decoded.uvs = capture::decode_stream(capture, draw.uv, draw.vertex_count, 2);
  if (needs.tangents) decoded.tangents = capture::decode_stream(capture, draw.tangent, draw.vertex_count, 4);
  if (needs.second_uvs) decoded.second_uvs = capture::decode_stream(capture, draw.uv2, draw.vertex_count, 2);
  if (needs.colours) decoded.colours = capture::decode_stream(capture, draw.colour, draw.vertex_count, 4);
  for (float& value : decoded.uvs) value = finite_uv(value);
  for (float& value : decoded.second_uvs) value = finite_uv(value);
  for (float& value : decoded.colours) value = finite_colour(value);
  for (float& value : decoded.tangents)
    if (!(std::abs(value) <= 1e6f)) value = 0;
  for (std::size_t i = 0; i < decoded.normals.size() / 3; ++i) {
    const glm::vec3 normal = unit(vec3_at(decoded.normals, i));
    for (int c = 0; c < 3; ++c) decoded.normals[3 * i + static_cast<std::size_t>(c)] = normal[c];
  }
  std::vector<std::uint32_t> order;
  if (set.flat || set.make_tangents) order = capture::decode_indices(capture, draw);
  if (set.flat) {
    decoded.positions = expanded(decoded.positions, 3, order);
    decoded.uvs = expanded(decoded.uvs, 2, order);
    decoded.tangents = expanded(decoded.tangents, 4, order);
    decoded.second_uvs = expanded(decoded.second_uvs, 2, order);
    decoded.colours = expanded(decoded.colours, 4, order);
    decoded.normals = flat_normals(decoded.positions);
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  }
  if (set.make_tangents) {
    const auto uvs = mapped_uvs(decoded, normal_mapping(capture.materials[draw.material]));
    decoded.tangents = tangents_from_uvs(decoded.positions, decoded.normals, uvs, order);
  }
  return decoded;
}

void put(std::span<float> to, std::size_t first_vertex, std::size_t width, const std::vector<float>& values) {
  std::copy(values.begin(), values.end(), to.begin() + static_cast<std::ptrdiff_t>(first_vertex * width));
}

}  // namespace

GeometryPlan plan_geometry(const capture::Capture& capture, VertexNeeds needs) {
  GeometryPlan plan;
  plan.needs = needs;
  std::unordered_map<Key, std::uint32_t, KeyHash> sets, meshes;
  std::uint64_t vertices = 0;
  for (std::uint32_t f = 0; f < capture.frames.size(); ++f) {
    const auto& draws = capture.frames[f].draws;
    auto& mesh_of_draw = plan.mesh_of_draw.emplace_back();
    mesh_of_draw.reserve(draws.size());
    for (std::uint32_t d = 0; d < draws.size(); ++d) {
      const auto& draw = draws[d];
      if (draw.topology != capture::Topology::triangle_list)
        throw std::logic_error("strips and fans become lists before they are replayed (make_triangle_lists)");
      const auto& material = capture.materials[draw.material];
      const bool mapped = textures_of(material)[2] != capture::kNone;
      const capture::UvMapping mapping = normal_mapping(material);
      VertexSet set{{f, d}, 0, draw.vertex_count, draw.normal.buffer == capture::kNone, false};
      const bool has_uvs = mapping.set == 0 ? needs.uvs && draw.uv.buffer != capture::kNone
                                            : needs.second_uvs && draw.uv2.buffer != capture::kNone;
      set.make_tangents = needs.tangents && mapped && draw.tangent.buffer == capture::kNone && has_uvs;
      Key key{};
      put_stream(key, 0, draw.position, true);
      put_stream(key, 3, draw.normal, true);
      put_stream(key, 6, draw.uv, needs.uvs);
      put_stream(key, 9, draw.tangent, needs.tangents);
      key[12] = draw.vertex_count;
      key[13] = (set.flat ? 1u : 0u) | (set.make_tangents ? 2u : 0u);
      // What is made from triangles belongs to one index range.
      if (set.flat || set.make_tangents) put_indices(key, 14, draw);
      put_stream(key, 18, draw.uv2, needs.second_uvs);
      put_stream(key, 21, draw.colour, needs.colours);
      if (set.make_tangents) put_mapping(key, 24, mapping);
      if (set.flat) set.vertex_count = draw.index_count;
      const auto [vertex_set, new_set] = sets.try_emplace(key, static_cast<std::uint32_t>(plan.vertex_sets.size()));
      if (new_set) {
        set.first_vertex = static_cast<std::uint32_t>(vertices);
        vertices += set.vertex_count;
        if (vertices > std::numeric_limits<std::uint32_t>::max())
          throw DeviceError("scene", "more vertices than 32-bit indices address",
                            fmt::format("frame {} draw {}", f, d));
        plan.vertex_sets.push_back(set);
      }
      Key mesh_key{};
      mesh_key[0] = vertex_set->second;
      put_indices(mesh_key, 1, draw);
      const auto [mesh, new_mesh] = meshes.try_emplace(mesh_key, static_cast<std::uint32_t>(plan.meshes.size()));
      if (new_mesh) {
        if (plan.index_count + draw.index_count > std::numeric_limits<std::uint32_t>::max())
          throw DeviceError("scene", "more indices than 32 bits count", fmt::format("frame {} draw {}", f, d));
        plan.meshes.push_back(
            {{f, d}, vertex_set->second, static_cast<std::uint32_t>(plan.index_count), draw.index_count / 3});
        plan.index_count += draw.index_count;
      }
      mesh_of_draw.push_back(mesh->second);
    }
  }
  plan.vertex_count = static_cast<std::uint32_t>(vertices);
  return plan;
}

std::vector<Bounds> fill_geometry(const capture::Capture& capture, const GeometryPlan& plan,
                                  const GeometryArrays& arrays) {
  // Meshes by the vertex set they use, so that each set is decoded once and its positions are still at hand.
  std::vector<std::vector<std::uint32_t>> meshes_of_set(plan.vertex_sets.size());
  for (std::uint32_t m = 0; m < plan.meshes.size(); ++m) meshes_of_set[plan.meshes[m].vertex_set].push_back(m);

  std::vector<Bounds> bounds(plan.meshes.size());
  for (std::size_t s = 0; s < plan.vertex_sets.size(); ++s) {
    const auto& set = plan.vertex_sets[s];
    DecodedSet decoded = decode(capture, set, plan.needs);
    put(arrays.positions, set.first_vertex, 3, decoded.positions);
    put(arrays.normals, set.first_vertex, 3, decoded.normals);
    if (plan.needs.uvs) put(arrays.uvs, set.first_vertex, 2, decoded.uvs);
    if (plan.needs.tangents) put(arrays.tangents, set.first_vertex, 4, decoded.tangents);
    if (plan.needs.second_uvs) put(arrays.second_uvs, set.first_vertex, 2, decoded.second_uvs);
    if (plan.needs.colours && decoded.colours.empty()) decoded.colours.assign(4 * std::size_t{set.vertex_count}, 1.0f);
    if (plan.needs.colours) put(arrays.colours, set.first_vertex, 4, decoded.colours);
    for (const std::uint32_t m : meshes_of_set[s]) {
      const auto& mesh = plan.meshes[m];
      std::vector<std::uint32_t> order = capture::decode_indices(capture, draw_of(capture, mesh.source));
      if (set.flat)
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
      for (std::size_t i = 0; i < order.size(); ++i) {
        bounds[m].add(vec3_at(decoded.positions, order[i]));
        arrays.indices[mesh.first_index + i] = set.first_vertex + order[i];
      }
    }
  }
  return bounds;
}

}  // namespace subpixel::replay
