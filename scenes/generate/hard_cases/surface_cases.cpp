// Hard cases of surfaces and light.
#include <array>
#include <string>

#include "scenes/generate/hard_cases/case_parts.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_parts.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

// Strips of a quarter of a pixel in one plane, with normals to the left and to the right in turn: their mean has no
// length. The sun comes from the right, so half of the strips are lit.
Capture hard_opposite_normals(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_opposite_normals", options);
  scene.environment.sun = DirectionalLight{{-0.7f, 0, -0.7f}, {4, 4, 4}, false};
  const double width = 0.25 * pixel_side(kDistance, options);
  const int count = static_cast<int>(2 * options.width);
  Mesh strips;
  for (int i = 0; i < count; ++i) {
    const int place = i - count / 2;
    add_quad(strips, {place * width, -1, 0}, {width, 0, 0}, {0, 2, 0});
    for (int k = 1; k <= 4; ++k)
      strips.normals[strips.normals.size() - static_cast<std::size_t>(k)] = {i % 2 == 0 ? 1 : -1, 0, 0};
  }
  scene.draw(scene.add_mesh("strips", strips), "strips", add_plain_material(scene, "grey", {0.6, 0.6, 0.6}, 0.5));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Spheres of roughness 0 and 1, dielectric and metal, under the sun and two point lights.
Capture hard_roughness(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_roughness", options);
  scene.environment.point_lights = {{{-2, 2, 2}, {6, 6, 6}, 12}, {{2.5f, -1, 2.5f}, {3, 4, 6}, 12}};
  Mesh mesh;
  add_sphere(mesh, {0, 0, 0}, 0.48, 16);
  const Draw sphere = scene.add_mesh("sphere", mesh);
  for (int i = 0; i < 4; ++i) {
    const int column = i % 2, row = i / 2;
    const std::string name = column == 0 ? "smooth" : "rough";
    scene.draw(sphere, name, add_plain_material(scene, name, {0.9, 0.6, 0.3}, column, row),
               translation({1.05 * column - 0.525, 1.05 * row - 0.525, 0}));
  }
  return scene.finish(case_camera(3.2), options.frames, options.width, options.height);
}

// Bars of 0.15 pixels in every direction and at every depth: each pixel shows about ten, in eight materials.
Capture hard_overflow(const GenerateOptions& options) {
  constexpr int kMaterials = 8;
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_overflow", options);
  Random random(options.seed);
  const double pixel = pixel_side(kDistance, options);
  const double side = options.height * pixel;
  std::array<Mesh, kMaterials> meshes;
  const int count = static_cast<int>(10 * options.width);
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 at{random.between(-0.7, 0.7) * side, random.between(-0.5, 0.5) * side, random.between(-0.5, 0.5)};
    const double angle = random.between(0, kPi);
    const glm::dvec3 along = glm::dvec3(cosine(angle), sine(angle), random.between(-0.5, 0.5)) * (0.3 * side);
    add_strip(meshes[random.below(kMaterials)], at - along, at + along, 0.15 * pixel);
  }
  for (int m = 0; m < kMaterials; ++m) {
    Material material;
    material.name = "bars " + std::to_string(m);
    material.base_colour = {m % 2 == 0 ? 0.9f : 0.1f, m / 2 % 2 == 0 ? 0.8f : 0.1f, m < 4 ? 0.1f : 0.7f, 1};
    material.roughness = 0.3f + 0.08f * static_cast<float>(m);
    material.two_sided = true;
    scene.draw(scene.add_mesh(material.name, meshes[static_cast<std::size_t>(m)]), material.name,
               scene.add_material(material));
  }
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

Capture hard_alpha_foliage(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_alpha_foliage", options);
  Random random(options.seed);
  Material leaf;
  leaf.name = "leaf";
  leaf.base_colour_texture = scene.add_texture(leaf_texture("leaf", 64, {86, 140, 52}, options.seed));
  leaf.alpha_mode = AlphaMode::test;
  leaf.two_sided = true;
  Mesh cards;
  for (int i = 0; i < 40; ++i) {
    const glm::dvec3 at{random.between(-1.6, 1.6), random.between(-1.2, 1.0), random.between(-1, 1)};
    const double turn = random.between(0, 2 * kPi), lean = random.between(-0.6, 0.6), size = random.between(0.3, 0.7);
    const glm::dvec3 right(cosine(turn), sine(lean), sine(turn)), up(-sine(lean), cosine(lean), 0.3);
    // uv once across the card, whatever its size: a square texel stays one.
    add_quad(cards, at, right * size, up * size, 1 / size);
  }
  scene.draw(scene.add_mesh("cards", cards), "cards", scene.add_material(leaf));
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

// A light of 1e6 before a white wall, and bars that reflect nothing before the wall.
Capture hard_bright_light(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = dark_case("hard_bright_light", options);
  scene.environment.exposure = 1e-4f;
  scene.environment.point_lights = {{{-1, 0.5f, 4}, {1e6f, 1e6f, 1e6f}, 40}};
  Mesh wall, bars;
  add_quad(wall, {-4, -3, 0}, {4.5, 0, 0}, {0, 6, 0});
  scene.draw(scene.add_mesh("wall", wall), "wall", add_plain_material(scene, "white", {0.9, 0.9, 0.9}, 0.9));
  const double pixel = pixel_side(kDistance, options);
  for (int i = 0; i < 16; ++i)
    add_strip(bars, {-2.4 + 0.27 * i, -1.4, 0.2}, {-2.2 + 0.27 * i, 1.4, 0.2}, (0.2 + 0.12 * i) * pixel);
  add_quad(bars, {0.5, -3, 0}, {4, 0, 0}, {0, 6, 0});
  scene.draw(scene.add_mesh("bars", bars), "bars", add_plain_material(scene, "black", {0, 0, 0}, 1, 1));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// No light but the surfaces': from a ten-thousandth to ten thousand.
Capture hard_emissive_only(const GenerateOptions& options) {
  SceneBuilder scene = dark_case("hard_emissive_only", options);
  constexpr std::array<float, 6> kRadiance{1e-4f, 0.02f, 0.3f, 1, 25, 1e4f};
  for (std::size_t i = 0; i < kRadiance.size(); ++i) {
    Mesh mesh;
    const double x = -1.7 + 0.55 * static_cast<double>(i);
    add_quad(mesh, {x, -1.1, 0.1 * static_cast<double>(i)}, {0.5, 0.07, 0}, {-0.06, 2.1, 0});
    const std::string name = "lamp " + std::to_string(i);
    const float value = kRadiance[i];
    scene.draw(scene.add_mesh(name, mesh), name, add_emitting(scene, name, {value, 0.5f * value, 0.25f * value}));
  }
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

// 300 point lights, more than any of the papers' counts, all in every pixel's loop.
Capture hard_many_lights(const GenerateOptions& options) {
  constexpr int kLights = 300;
  SceneBuilder scene = dark_case("hard_many_lights", options);
  Random random(options.seed);
  Mesh floor, posts;
  add_quad(floor, {-6, -0.8, 2}, {12, 0, 0}, {0, 0, -12});
  scene.draw(scene.add_mesh("floor", floor), "floor", add_plain_material(scene, "floor", {0.6, 0.6, 0.6}, 0.6));
  for (int i = 0; i < 20; ++i) {
    const double x = -3 + 0.3 * i, z = -0.4 * (i % 5);
    add_box(posts, {x, -0.8, z}, {x + 0.04, 0.8, z + 0.04});
  }
  scene.draw(scene.add_mesh("posts", posts), "posts", add_plain_material(scene, "posts", {0.7, 0.3, 0.2}, 0.4));
  for (int i = 0; i < kLights; ++i) {
    PointLight light;
    light.position = {static_cast<float>(random.between(-3, 3)), static_cast<float>(random.between(-0.7, 0.5)),
                      static_cast<float>(random.between(-5, 1))};
    light.intensity = {static_cast<float>(random.between(0, 0.1)), static_cast<float>(random.between(0, 0.1)),
                       static_cast<float>(random.between(0, 0.1))};
    light.range = 2;
    scene.environment.point_lights.push_back(light);
  }
  return scene.finish(case_camera(3), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
