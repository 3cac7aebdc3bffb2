// Captures of a few triangles, made by hand, for the tests of the scene and of the reference.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::replay {

// A capture with one frame, seen through an orthographic camera: world x and y in [-1, 1] fill the image, y up, z from
// -1 (far) to 1 (near) is visible. No lights; the sky is black and the ambient term white.
inline capture::Capture flat_capture(std::uint32_t width, std::uint32_t height) {
  capture::Capture capture;
  capture.metadata.title = "fixture";
  capture::Frame frame;
  frame.view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  frame.projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0.5f, 1};
  frame.clip_depth = capture::ClipDepth::one_to_zero;
  frame.width = width;
  frame.height = height;
  frame.sky = {0, 0, 0};
  frame.ambient = {1, 1, 1};
  capture.frames.push_back(frame);
  return capture;
}

template <typename T>
std::uint32_t add_buffer(capture::Capture& capture, const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  capture.buffers.push_back({"values", {bytes.begin(), bytes.end()}});
  return static_cast<std::uint32_t>(capture.buffers.size() - 1);
}

// A material that sends the same radiance everywhere and reflects nothing but what the ambient term adds to black.
inline std::uint32_t add_emitter(capture::Capture& capture, capture::Float3 radiance) {
  capture::Material material;
  material.name = "emitter";
  material.base_colour = {0, 0, 0, 1};
  material.emissive = radiance;
  capture.materials.push_back(material);
  return static_cast<std::uint32_t>(capture.materials.size() - 1);
}

// Appends an unindexed draw of `corners` (three floats each) without normals to the last frame.
inline capture::Draw& add_triangles(capture::Capture& capture, const std::vector<float>& corners,
                                    std::uint32_t material) {
  capture::Draw draw;
  draw.name = "triangles";
  draw.material = material;
  draw.position = {add_buffer(capture, corners), capture::VertexFormat::float32x3, 0, 12};
  draw.vertex_count = draw.index_count = static_cast<std::uint32_t>(corners.size() / 3);
  capture.frames.back().draws.push_back(draw);
  return capture.frames.back().draws.back();
}

// Two triangles, counter-clockwise seen from +z, over [x0, x1] x [y0, y1] at height z.
inline std::vector<float> rectangle(float x0, float y0, float x1, float y1, float z) {
  return {x0, y0, z, x1, y0, z, x1, y1, z, x0, y0, z, x1, y1, z, x0, y1, z};
}

// The uvs of rectangle()'s corners: (0, 0) at (x0, y1), the top left, as texture rows go.
inline std::vector<float> rectangle_uvs() {
  return {0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0};
}

inline std::uint32_t add_texture(capture::Capture& capture, std::uint32_t width, std::uint32_t height,
                                 const std::vector<std::uint8_t>& texels, bool srgb) {
  const auto bytes = std::as_bytes(std::span(texels));
  capture.textures.push_back(
      {"texels", capture::TextureEncoding::rgba8, srgb, width, height, {bytes.begin(), bytes.end()}});
  return static_cast<std::uint32_t>(capture.textures.size() - 1);
}

}  // namespace subpixel::replay
