// A scene whose surfaces need every input a material can have: all four textures placed on their own, samplers, vertex
// colours, an alpha test, a scaled normal map, an unlit material, a sun with shadows, a point light and a spot light.
#pragma once

#include <cmath>
#include <random>

#include "tests/unit/scene_fixture.hpp"

namespace subpixel::replay {

inline constexpr std::uint32_t kRichWidth = 48, kRichHeight = 36;

// Where textures get their coordinates from; all three place them alike.
enum class UvSource {
  transforms,  // of the first set
  baked,       // two sets, as they are
  mixed,       // one set as it is, the other transformed
};

namespace rich {

using Matrix = std::array<float, 6>;
// Of base colour and normal map, and of the two others: turned, scaled and moved.
inline constexpr Matrix kFirst{0.8f, 0.6f, 0.25f, -0.6f, 0.8f, 0.125f}, kSecond{0.0f, 1.5f, 0.5f, -2.0f, 0.0f, 0.75f};

inline std::vector<float> mapped(const std::vector<float>& uvs, const Matrix& m) {
  std::vector<float> result(uvs.size());
  for (std::size_t i = 0; i < uvs.size(); i += 2) {
    result[i] = m[0] * uvs[i] + m[1] * uvs[i + 1] + m[2];
    result[i + 1] = m[3] * uvs[i] + m[4] * uvs[i + 1] + m[5];
  }
  return result;
}

inline std::uint32_t random_texture(capture::Capture& capture, std::uint32_t seed, bool normals) {
  constexpr std::uint32_t kSide = 8;
  std::mt19937 random(seed);
  std::vector<std::uint8_t> texels;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const auto near = [&] { return static_cast<std::uint8_t>(128 + random() % 96 - 48); };
    const auto any = [&] { return static_cast<std::uint8_t>(random() % 256); };
    texels.push_back(normals ? near() : any());
    texels.push_back(normals ? near() : any());
    texels.push_back(normals ? 240 : any());
    texels.push_back(normals ? 255 : any());
  }
  return add_texture(capture, kSide, kSide, texels, false);
}

}  // namespace rich

inline capture::Capture rich_scene(UvSource source) {
  using namespace rich;
  auto capture = flat_capture(kRichWidth, kRichHeight);
  auto& frame = capture.frames[0];
  frame.sky = {0.1f, 0.2f, 0.4f};
  frame.ambient = {0.3f, 0.3f, 0.3f};
  frame.sun = capture::DirectionalLight{{-0.3f, -0.2f, -0.9f}, {1.5f, 1.5f, 1.5f}, true};
  frame.point_lights = {{{-0.5f, 0.5f, 0.9f}, {0.3f, 0.2f, 0.1f}, 3},
                        {{0.5f, 0.2f, 0.9f}, {0.6f, 0.6f, 0.9f}, 3, capture::SpotCone{{0, 0, -1}, 0.9f, 0.6f}}};

  capture::Material textured;
  textured.metallic = 0.7f;
  textured.roughness = 0.9f;
  textured.emissive = {0.4f, 0.3f, 0.2f};
  textured.normal_scale = 0.6f;
  textured.base_colour_texture = random_texture(capture, 1, false);
  textured.metallic_roughness_texture = random_texture(capture, 2, false);
  textured.normal_texture = random_texture(capture, 3, true);
  textured.emissive_texture = random_texture(capture, 4, false);
  capture.textures[0].sampler = {capture::Wrap::mirrored_repeat, capture::Wrap::repeat};
  capture.textures[3].sampler.wrap_v = capture::Wrap::clamp_to_edge;
  const bool first_baked = source != UvSource::transforms, second_baked = source == UvSource::baked;
  if (!first_baked) textured.base_colour_uv.matrix = textured.normal_uv.matrix = kFirst;
  if (second_baked) textured.metallic_roughness_uv.set = textured.emissive_uv.set = 1;
  if (source == UvSource::mixed) {
    // The untransformed coordinates are the second set.
    textured.metallic_roughness_uv = textured.emissive_uv = {1, kSecond};
  } else if (source == UvSource::transforms) {
    textured.metallic_roughness_uv.matrix = textured.emissive_uv.matrix = kSecond;
  }
  capture::Material cut = textured;
  cut.alpha_mode = capture::AlphaMode::test;
  cut.alpha_cutoff = 0.4f;
  cut.two_sided = true;
  capture::Material unlit;
  unlit.unlit = true;
  unlit.base_colour = {0.9f, 0.5f, 0.1f, 1};
  capture.materials = {textured, cut, unlit};

  const auto add = [&](const std::vector<float>& corners, std::uint32_t material) {
    auto& draw = add_triangles(capture, corners, material);
    const auto uvs = rectangle_uvs();
    const auto stream = [&](const std::vector<float>& values) {
      return capture::VertexStream{add_buffer(capture, values), capture::VertexFormat::float32x2, 0, 8};
    };
    draw.uv = stream(first_baked ? mapped(uvs, kFirst) : uvs);
    if (source != UvSource::transforms) draw.uv2 = stream(second_baked ? mapped(uvs, kSecond) : uvs);
    std::vector<float> colours;
    for (std::size_t i = 0; i < corners.size(); i += 3)
      colours.insert(colours.end(), {corners[i] * 0.4f + 0.6f, corners[i + 1] * 0.4f + 0.6f, 0.8f, 0.95f});
    draw.colour = {add_buffer(capture, colours), capture::VertexFormat::float32x4, 0, 16};
  };
  add(rectangle(-1, -0.9f, 0.9f, 0.9f, -0.5f), 0);
  add(rectangle(-0.6f, -0.5f, 0.3f, 0.6f, 0.1f), 1);
  add(rectangle(0.2f, -0.8f, 0.7f, -0.2f, 0.4f), 2);
  return capture;
}

}  // namespace subpixel::replay
