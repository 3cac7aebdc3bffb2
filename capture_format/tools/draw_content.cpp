#include "capture_format/tools/draw_content.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/hash.hpp"
#include "capture_format/streams.hpp"

namespace subpixel::capture {
namespace {

class Hasher {
 public:
  template <typename T>
  void add(const std::vector<T>& values) {
    hasher_.add(std::as_bytes(std::span(values)));
  }
  template <typename T>
  void add_value(const T& value) {
    hasher_.add(std::as_bytes(std::span(&value, 1)));
  }
  // Of equal numbers, which -0 and 0 are.
  void add_numbers(std::span<const float> values) {
    for (const float value : values) add_value(value + 0.0f);
  }
  Hash hash() const {
    const ContentHash hash = hasher_.hash();
    return {hash.high, hash.low};
  }

 private:
  ContentHasher hasher_;
};

using Point = std::array<double, 3>;

Point transformed(const Matrix4& m, const Point& p) {
  Point result;
  for (std::size_t r = 0; r < 3; ++r) result[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
  return result;
}

// The values of one stream at the corners, one after the other. Only what lies between the first and the last vertex
// that is read is decoded: large buffers hold many meshes.
std::vector<float> values_at(const Capture& capture, VertexStream stream, const std::vector<std::uint32_t>& corners,
                             std::uint32_t components) {
  if (corners.empty()) return {};
  const auto [lowest, highest] = std::minmax_element(corners.begin(), corners.end());
  const std::uint32_t first = *lowest;
  stream.offset += std::uint64_t{first} * stream.stride;
  const std::vector<float> values = decode_stream(capture, stream, *highest - first + 1, components);
  std::vector<float> in_order(corners.size() * components);
  for (std::size_t c = 0; c < corners.size(); ++c) {
    std::copy_n(&values[std::size_t{corners[c] - first} * components], components, &in_order[c * components]);
  }
  return in_order;
}

}  // namespace

Box::Box() {
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
}

void Box::add(const Point& point) {
  if (!std::isfinite(point[0] + point[1] + point[2])) return;
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = std::min(low[i], point[i]);
    high[i] = std::max(high[i], point[i]);
  }
}

double Box::diagonal() const {
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

Point Box::middle() const {
  return {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
}

double distance(const Box& a, const Box& b) {
  if (a.empty() || b.empty()) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    most = std::max({most, std::abs(a.low[i] - b.low[i]), std::abs(a.high[i] - b.high[i])});
  }
  return most;
}

DrawContents::DrawContents(const Capture& capture) : capture_(capture) {
  for (const Texture& texture : capture.textures) {
    Hasher hasher;
    hasher.add(texture.bytes);
    hasher.add_value(std::array{static_cast<std::uint32_t>(texture.encoding), std::uint32_t{texture.srgb},
                                texture.width, texture.height});
    hasher.add_value(texture.sampler);
    textures_.push_back(hasher.hash());
  }
  for (const Material& material : capture.materials) materials_.push_back(material_hash(material));
}

const MeshContent& DrawContents::mesh(const Draw& draw) {
  MeshKey key{{}, draw.index_buffer, draw.index_type, draw.index_offset, draw.index_count, draw.base_vertex};
  for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
    const VertexStream& stream = draw.*kStreamsOfDraw[i].member;
    if (stream.buffer == kNone) {
      std::get<0>(key)[i] = {kNone, VertexFormat{}, 0, 0};
    } else {
      std::get<0>(key)[i] = {stream.buffer, stream.format, stream.offset, stream.stride};
    }
  }
  const auto [found, is_new] = meshes_.try_emplace(key);
  if (is_new) found->second = read_mesh(draw);
  return found->second;
}

Hash DrawContents::placement(const Draw& draw) const {
  Hasher hasher;
  hasher.add(world_transforms(capture_, draw));
  return hasher.hash();
}

Box DrawContents::world_box(const Draw& draw) const {
  const std::vector<float> positions = values_at(capture_, draw.position, decode_indices(capture_, draw), 3);
  Box box;
  for (const Matrix4& place : world_transforms(capture_, draw)) {
    for (std::size_t i = 0; i < positions.size(); i += 3) {
      box.add(transformed(place, {positions[i], positions[i + 1], positions[i + 2]}));
    }
  }
  return box;
}

MeshContent DrawContents::read_mesh(const Draw& draw) const {
  MeshContent mesh;
  const std::vector<std::uint32_t> corners = decode_indices(capture_, draw);
  mesh.triangles = corners.size() / 3;
  Hasher all;
  for (std::size_t i = 0; i < kStreamsOfDraw.size(); ++i) {
    const VertexStream& stream = draw.*kStreamsOfDraw[i].member;
    mesh.present[i] = stream.buffer != kNone;
    Hasher hasher;
    hasher.add_value(mesh.present[i]);
    if (mesh.present[i]) {
      const std::vector<float> values = values_at(capture_, stream, corners, kStreamsOfDraw[i].components);
      hasher.add(values);
      for (std::size_t c = 0; i == kPositionOfDraw && c < values.size(); c += 3) {
        mesh.box.add({values[c], values[c + 1], values[c + 2]});
      }
    }
    mesh.streams[i] = hasher.hash();
    all.add_value(mesh.streams[i]);
  }
  mesh.all = all.hash();
  return mesh;
}

Hash DrawContents::material_hash(const Material& m) const {
  Hasher hasher;
  hasher.add_value(
      std::array{static_cast<std::uint32_t>(m.alpha_mode), std::uint32_t{m.two_sided}, std::uint32_t{m.unlit}});
  hasher.add_numbers(m.base_colour);
  hasher.add_numbers(std::array{m.alpha_cutoff, m.metallic, m.roughness, m.normal_scale});
  hasher.add_numbers(m.emissive);
  for (const UvMapping* uv : {&m.base_colour_uv, &m.metallic_roughness_uv, &m.normal_uv, &m.emissive_uv}) {
    hasher.add_value(uv->set);
    hasher.add_numbers(uv->matrix);
  }
  for (const TextureOfMaterial& slot : kTexturesOfMaterial) {
    const std::optional<Hash> content = texture(m.*slot.member);
    hasher.add_value(content.has_value());
    hasher.add_value(content.value_or(Hash{}));
  }
  return hasher.hash();
}

// A difference of affine maps is affine, so it is largest at a corner of the box.
std::optional<double> moved_distance(const Capture& in_a, const Draw& a, const Capture& in_b, const Draw& b,
                                     const Box& mesh) {
  const std::vector<Matrix4> before = world_transforms(in_a, a), after = world_transforms(in_b, b);
  if (before.size() != after.size() || mesh.empty()) return std::nullopt;
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (unsigned corner = 0; corner < 8; ++corner) {
      Point at;
      for (unsigned axis = 0; axis < 3; ++axis) at[axis] = (corner >> axis & 1) == 0 ? mesh.low[axis] : mesh.high[axis];
      const Point from = transformed(before[i], at), to = transformed(after[i], at);
      const double distance = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
      if (!std::isfinite(distance)) return std::nullopt;
      most = std::max(most, distance);
    }
  }
  return most;
}

}  // namespace subpixel::capture
