// What both test applications draw, frame after frame the same but for a moving camera, bones and cubes: a ground of
// strips with restarts, instanced cubes with a base vertex, a skinned tube without indices, a fan, alpha-tested cards,
// a decal blended over some of the ground's triangles at equal depth, and a blended pane that an exporter must leave
// out.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace scene {

using Matrix = std::array<float, 16>;  // column-major

struct Vertex {
  float position[3], normal[3], uv[2], bone;
};

enum class Topology { list, strip, fan };

struct Part {
  Topology topology = Topology::list;
  bool indexed = true, discards = false, blends = false, skinned = false, two_sided = false, decal = false;
  std::uint32_t first = 0, count = 0;  // indices, or vertices where it has none
  std::int32_t base_vertex = 0;
  std::uint32_t instances = 1, first_instance = 0;
  Matrix model{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};

inline float opacity(const Part& part) {
  return part.blends && !part.decal ? 0.4f : 1;
}

inline constexpr std::uint16_t kRestart = 0xffff;
inline constexpr std::uint32_t kWidth = 320, kHeight = 240, kTextureSide = 64;

struct Scene {
  std::vector<Vertex> vertices;
  std::vector<std::uint16_t> indices;
  std::vector<std::array<float, 3>> instances;
  std::vector<Part> parts;
};

inline Matrix moved(float x, float y, float z, float scale = 1, float turn = 0) {
  const float c = std::cos(turn) * scale, s = std::sin(turn) * scale;
  return {c, 0, -s, 0, 0, scale, 0, 0, s, 0, c, 0, x, y, z, 1};
}

inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      for (int k = 0; k < 4; ++k) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    }
  }
  return out;
}

inline void add_quad(Scene& scene, const std::array<float, 3>& corner, const std::array<float, 3>& u,
                     const std::array<float, 3>& v, bool indexed) {
  const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const auto at = [&](float s, float t) {
    Vertex out{};
    for (int i = 0; i < 3; ++i) {
      out.position[i] = corner[i] + s * u[i] + t * v[i];
      out.normal[i] = n[i] / length;
    }
    out.uv[0] = s, out.uv[1] = t;
    return out;
  };
  const auto first = static_cast<std::uint16_t>(scene.vertices.size());
  const float order[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  if (indexed) {
    for (const int i : {0, 1, 2, 5}) scene.vertices.push_back(at(order[i][0], order[i][1]));
    for (const int i : {0, 1, 2, 0, 2, 3}) scene.indices.push_back(static_cast<std::uint16_t>(first + i));
  } else {
    for (const auto& [s, t] : order) scene.vertices.push_back(at(s, t));
  }
}

inline Scene make_scene(float time) {
  Scene scene;
  // The ground: strips of quads across, broken between rows.
  constexpr int kCells = 12;
  Part ground{.topology = Topology::strip};
  for (int z = 0; z <= kCells; ++z) {
    for (int x = 0; x <= kCells; ++x) {
      const float height = 0.15f * std::sin(0.9f * static_cast<float>(x)) * std::cos(0.7f * static_cast<float>(z));
      scene.vertices.push_back({{static_cast<float>(x) - 6, height, static_cast<float>(z) - 6},
                                {0, 1, 0},
                                {static_cast<float>(x) / 3, static_cast<float>(z) / 3},
                                0});
    }
  }
  for (int z = 0; z < kCells; ++z) {
    for (int x = 0; x <= kCells; ++x) {
      scene.indices.push_back(static_cast<std::uint16_t>(z * (kCells + 1) + x));
      scene.indices.push_back(static_cast<std::uint16_t>((z + 1) * (kCells + 1) + x));
    }
    scene.indices.push_back(kRestart);
  }
  ground.count = static_cast<std::uint32_t>(scene.indices.size());
  scene.parts.push_back(ground);

  // Cubes: 0-based indices from a base vertex, one for each instance.
  Part cubes;
  cubes.first = static_cast<std::uint32_t>(scene.indices.size());
  cubes.base_vertex = static_cast<std::int32_t>(scene.vertices.size());
  cubes.count = 36, cubes.instances = 7, cubes.first_instance = 1;
  Scene cube;
  add_quad(cube, {-.5f, -.5f, .5f}, {1, 0, 0}, {0, 1, 0}, true);
  add_quad(cube, {.5f, -.5f, -.5f}, {-1, 0, 0}, {0, 1, 0}, true);
  add_quad(cube, {.5f, -.5f, .5f}, {0, 0, -1}, {0, 1, 0}, true);
  add_quad(cube, {-.5f, -.5f, -.5f}, {0, 0, 1}, {0, 1, 0}, true);
  add_quad(cube, {-.5f, .5f, .5f}, {1, 0, 0}, {0, 0, -1}, true);
  add_quad(cube, {-.5f, -.5f, -.5f}, {1, 0, 0}, {0, 0, 1}, true);
  scene.vertices.insert(scene.vertices.end(), cube.vertices.begin(), cube.vertices.end());
  scene.indices.insert(scene.indices.end(), cube.indices.begin(), cube.indices.end());
  cubes.model = moved(0, 0.8f, 0, 0.7f, time);
  scene.instances.push_back({0, 0, 0});  // of all draws without instances
  for (int i = 0; i < 7; ++i) {
    scene.instances.push_back({3.5f * std::cos(0.9f * static_cast<float>(i)), 0.2f * static_cast<float>(i % 3),
                               3.5f * std::sin(0.9f * static_cast<float>(i))});
  }
  scene.parts.push_back(cubes);

  // The tube: rings of quads, the upper ones follow the second bone.
  Part tube{.indexed = false, .skinned = true};
  tube.first = static_cast<std::uint32_t>(scene.vertices.size());
  constexpr int kSides = 12, kRings = 8;
  for (int ring = 0; ring < kRings; ++ring) {
    for (int side = 0; side < kSides; ++side) {
      for (const auto& [s, t] : {std::pair{0, 0}, {1, 1}, {1, 0}, {0, 0}, {0, 1}, {1, 1}}) {
        const float angle = 6.2831853f * static_cast<float>((side + s) % kSides) / kSides;
        const float up = static_cast<float>(ring + t) / kRings;
        scene.vertices.push_back({{0.4f * std::cos(angle), 2.5f * up, 0.4f * std::sin(angle)},
                                  {std::cos(angle), 0, std::sin(angle)},
                                  {static_cast<float>(side + s) / 4, 2 * up},
                                  up});
      }
    }
  }
  tube.count = static_cast<std::uint32_t>(scene.vertices.size()) - tube.first;
  scene.parts.push_back(tube);

  // The fan: a cone's mantle.
  Part fan{.topology = Topology::fan, .indexed = false};
  fan.first = static_cast<std::uint32_t>(scene.vertices.size());
  scene.vertices.push_back({{-2.5f, 2.2f, -1}, {0, 1, 0}, {0.5f, 0.5f}, 0});
  for (int i = 0; i <= 16; ++i) {
    const float angle = -6.2831853f * static_cast<float>(i) / 16;
    scene.vertices.push_back({{-2.5f + std::cos(angle), 0.4f, -1 + std::sin(angle)},
                              {std::cos(angle), 0.5f, std::sin(angle)},
                              {0.5f + 0.5f * std::cos(angle), 0.5f + 0.5f * std::sin(angle)},
                              0});
  }
  fan.count = 18;
  scene.parts.push_back(fan);

  // Cards with holes, seen from both sides.
  Part cards{.indexed = false, .discards = true, .two_sided = true};
  cards.first = static_cast<std::uint32_t>(scene.vertices.size());
  for (int i = 0; i < 4; ++i) {
    add_quad(scene, {1.5f + 0.5f * static_cast<float>(i), 0.1f, 2 - 0.6f * static_cast<float>(i)}, {0.9f, 0, 0.3f},
             {0, 1.4f, 0}, false);
  }
  cards.count = 24;
  scene.parts.push_back(cards);

  // The decal: two cells of the ground as the strips have them, four triangles.
  Part decal{.blends = true, .decal = true};
  decal.first = static_cast<std::uint32_t>(scene.indices.size());
  for (const int x : {8, 9}) {
    const int above = 9 * (kCells + 1) + x, below = above + kCells + 1;
    for (const int i : {above, below, above + 1, above + 1, below, below + 1}) {
      scene.indices.push_back(static_cast<std::uint16_t>(i));
    }
  }
  decal.count = 12;
  scene.parts.push_back(decal);

  Part pane{.indexed = false, .blends = true};
  pane.first = static_cast<std::uint32_t>(scene.vertices.size());
  add_quad(scene, {-1, 0.3f, 4}, {2, 0, 0}, {0, 1.5f, 0}, false);
  pane.count = 6;
  scene.parts.push_back(pane);
  return scene;
}

// Squares of two colours with an arrow-like corner, so that a flip shows; alpha 0 in round holes.
inline std::vector<std::uint8_t> make_texture() {
  std::vector<std::uint8_t> texels(4 * kTextureSide * kTextureSide);
  for (std::uint32_t y = 0; y < kTextureSide; ++y) {
    for (std::uint32_t x = 0; x < kTextureSide; ++x) {
      std::uint8_t* const texel = &texels[4 * (y * kTextureSide + x)];
      const bool odd = ((x / 16) + (y / 16)) % 2 != 0, corner = x + y < 24;
      texel[0] = corner ? 230 : odd ? 200 : 90;
      texel[1] = corner ? 40 : odd ? 190 : 120;
      texel[2] = corner ? 30 : odd ? 150 : 160;
      const int dx = static_cast<int>(x % 32) - 16, dy = static_cast<int>(y % 32) - 16;
      texel[3] = dx * dx + dy * dy < 80 ? 0 : 255;
    }
  }
  return texels;
}

// The decal's: blue, alpha 0 in the left half of each 32 texels.
inline std::vector<std::uint8_t> make_decal_texture() {
  std::vector<std::uint8_t> texels(4 * kTextureSide * kTextureSide);
  for (std::uint32_t i = 0; i < kTextureSide * kTextureSide; ++i) {
    texels[4 * i] = 20, texels[4 * i + 1] = 30, texels[4 * i + 2] = 250;
    texels[4 * i + 3] = i % 32 < 16 ? 0 : 255;
  }
  return texels;
}

struct Camera {
  Matrix view, projection, bones[2];
};

// `vulkan`: z from 0 to 1 and y down, else OpenGL's.
inline Camera make_camera(float time, bool vulkan) {
  Camera camera{};
  const float turn = 0.3f + 0.02f * time, tilt = 0.45f;
  const float ct = std::cos(tilt), st = std::sin(tilt);
  const Matrix pitch{1, 0, 0, 0, 0, ct, st, 0, 0, -st, ct, 0, 0, 0, 0, 1};
  camera.view = product(moved(0, 0, -9), product(pitch, product(moved(0, 0, 0, 1, turn), moved(0, -0.8f, 0))));
  constexpr float kNear = 0.5f, kFar = 40, kCotangent = 1.7f;
  const float aspect = static_cast<float>(kWidth) / kHeight;
  camera.projection[0] = kCotangent / aspect;
  camera.projection[5] = vulkan ? -kCotangent : kCotangent;
  camera.projection[10] = vulkan ? kFar / (kNear - kFar) : (kFar + kNear) / (kNear - kFar);
  camera.projection[11] = -1;
  camera.projection[14] = (vulkan ? 1.0f : 2.0f) * kFar * kNear / (kNear - kFar);
  camera.bones[0] = moved(0, 0, 0);
  const float bend = 0.5f + 0.1f * std::sin(time), cb = std::cos(bend), sb = std::sin(bend);
  camera.bones[1] = {cb, sb, 0, 0, -sb, cb, 0, 0, 0, 0, 1, 0, 0.3f, 0, 0, 1};
  return camera;
}

}  // namespace scene
