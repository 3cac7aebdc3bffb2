// A small capture that uses every kind of record, and the errors of reading changed ones.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "capture_format/capture.hpp"
#include "capture_format/reading/reader.hpp"

namespace subpixel::capture {

template <typename T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

inline Capture small_capture() {
  Capture capture;
  capture.metadata = {"Small", "a test", "a recorder 1", "CC0-1.0 – with a dash", 0.01f};
  // Interleaved: position float32x3, normal snorm8x4, uv unorm16x2; 4 vertices of 20 bytes.
  std::vector<std::byte> vertices(80);
  for (int i = 0; i < 4; ++i) {
    const float position[3] = {static_cast<float>(i % 2), static_cast<float>(i / 2), -2.0f};
    const std::int8_t normal[4] = {0, 0, 127, 0};
    std::memcpy(vertices.data() + 20 * i, position, sizeof position);
    std::memcpy(vertices.data() + 20 * i + 12, normal, sizeof normal);
  }
  Matrix4 moved{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1};
  capture.buffers = {{"vertices", vertices},
                     {"indices", bytes_of(std::vector<std::uint16_t>{9, 0, 1, 2, 2, 1, 3})},
                     {"placements", bytes_of(std::vector<Matrix4>{Draw{}.transform, moved})},
                     {"vertices again", vertices},
                     {"nothing", {}}};
  capture.textures = {{"dots", TextureEncoding::rgba8, true, 2, 1, std::vector<std::byte>(8, std::byte{77})},
                      {"file", TextureEncoding::image_file, false, 0, 0, std::vector<std::byte>(5, std::byte{3})}};
  Material plain;
  plain.name = "plain";
  Material leaf;
  leaf.name = "leaf";
  leaf.base_colour = {0.25f, 0.5f, 0.125f, 1};
  leaf.base_colour_texture = 0;
  leaf.normal_texture = 1;
  leaf.alpha_mode = AlphaMode::test;
  leaf.alpha_cutoff = 0.3f;
  leaf.emissive = {0, 1.5f, 20};
  leaf.two_sided = true;
  capture.materials = {plain, leaf};

  Draw indexed;
  indexed.name = "indexed";
  indexed.material = 1;
  indexed.position = {0, VertexFormat::float32x3, 0, 20};
  indexed.normal = {0, VertexFormat::snorm8x4, 12, 20};
  indexed.uv = {3, VertexFormat::unorm16x2, 16, 20};
  indexed.index_type = IndexType::uint16;
  indexed.index_buffer = 1;
  indexed.index_offset = 2;
  indexed.index_count = 6;
  indexed.vertex_count = 4;
  indexed.instance_buffer = 2;
  indexed.instance_count = 2;
  Draw plain_list;
  plain_list.name = "list";
  plain_list.position = {0, VertexFormat::float32x3, 0, 20};
  plain_list.index_count = 3;
  plain_list.base_vertex = 1;
  plain_list.vertex_count = 4;
  plain_list.transform = moved;

  Frame frame;
  frame.name = "first";
  frame.time_s = 0.5;
  frame.view = Draw{}.transform;
  frame.projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0};
  frame.width = 64;
  frame.height = 48;
  frame.sun = DirectionalLight{};
  frame.point_lights = {PointLight{}, PointLight{{1, 2, 3}, {4, 5, 6}, 7}};
  frame.draws = {indexed, plain_list};
  Frame empty = frame;
  empty.name = "empty";
  empty.clip_depth = ClipDepth::minus_one_to_one;
  empty.clip_y_up = true;
  empty.sun.reset();
  empty.point_lights.clear();
  empty.draws.clear();
  capture.frames = {frame, empty};
  return capture;
}

// The same with every field that version 2 of the format added, none at its default.
inline Capture version_2_capture() {
  Capture capture = small_capture();
  capture.metadata.notices = {"ignored: morph targets of 3 meshes", ""};
  capture.textures[0].sampler = {Wrap::clamp_to_edge, Wrap::mirrored_repeat, TexelFilter::nearest, TexelFilter::nearest,
                                 MipFilter::none};
  Material& leaf = capture.materials[1];
  leaf.normal_scale = -0.5f;
  leaf.unlit = true;
  leaf.base_colour_uv = {1, {2, 0, 0.25f, 0, 3, -1}};
  leaf.metallic_roughness_uv = {0, {1, 2, 3, 4, 5, 6}};
  leaf.normal_uv = {1, {0, -1, 0, 1, 0, 0}};
  leaf.emissive_uv = {0, {1, 0, 0, 0, 1, 7}};
  // 4 vertices of 12 bytes: uv2 float32x2, colour unorm8x4.
  std::vector<std::byte> more(48, std::byte{0});
  for (std::size_t i = 0; i < 4; ++i) {
    const float uv2[2] = {static_cast<float>(i), 0.5f};
    std::memcpy(more.data() + 12 * i, uv2, sizeof uv2);
    more[12 * i + 8 + i % 4] = std::byte{255};
  }
  capture.buffers.push_back({"more", more});
  Draw& draw = capture.frames[0].draws[0];
  draw.uv2 = {5, VertexFormat::float32x2, 0, 12};
  draw.colour = {5, VertexFormat::unorm8x4, 8, 12};
  capture.frames[0].point_lights[1].cone = SpotCone{{0, 0, -2}, 0.9f, -0.25f};
  return capture;
}

// The message with which decode_capture() refuses the bytes; empty when it takes them.
inline std::string refusal(std::span<const std::byte> bytes, const ReadLimits& limits = {}) {
  try {
    decode_capture(bytes, limits);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace subpixel::capture
