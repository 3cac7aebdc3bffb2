// Scenes of a few triangles, for tests and first looks.
#include <array>
#include <string>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scenes.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {
namespace {

SceneBuilder small_scene(const std::string& name, const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata(name, options));
  scene.environment.sun = DirectionalLight{{-0.4f, -0.7f, -0.6f}, {3, 3, 3}, false};
  return scene;
}

Material plain(const std::string& name, float red, float green, float blue) {
  Material material;
  material.name = name;
  material.base_colour = {red, green, blue, 1};
  return material;
}

// From (0, 0, distance) towards the origin, drifting by a few pixels in a second.
CameraPath drifting_camera(double distance) {
  return CameraPath({{0, {0, 0, distance}, {0, 0, 0}, 45}, {10, {0.5, 0.25, distance}, {0.5, 0.25, 0}, 45}});
}

}  // namespace

Capture triangle(const GenerateOptions& options) {
  SceneBuilder scene = small_scene("triangle", options);
  Mesh mesh;
  mesh.add_vertex({-1.0, -0.8, 0}, {0, 0, 1}, {0, 1});
  mesh.add_vertex({1.1, -0.5, 0}, {0, 0, 1}, {1, 1});
  mesh.add_vertex({-0.1, 1.0, 0}, {0, 0, 1}, {0.5, 0});
  mesh.add_triangle(0, 1, 2);
  scene.draw(scene.add_mesh("triangle", mesh), "triangle", scene.add_material(plain("red", 0.8f, 0.2f, 0.15f)));
  return scene.finish(drifting_camera(4), options.frames, options.width, options.height);
}

Capture empty(const GenerateOptions& options) {
  return small_scene("empty", options).finish(drifting_camera(4), options.frames, options.width, options.height);
}

Capture cube(const GenerateOptions& options) {
  SceneBuilder scene = small_scene("cube", options);
  Mesh mesh;
  add_box(mesh, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  scene.draw(scene.add_mesh("cube", mesh), "cube", scene.add_material(plain("blue", 0.2f, 0.35f, 0.8f)),
             euler_rotation_degrees({31, 37, 0}));
  return scene.finish(drifting_camera(3), options.frames, options.width, options.height);
}

Capture quads(const GenerateOptions& options) {
  SceneBuilder scene = small_scene("quads", options);
  Material leaf = plain("leaf", 1, 1, 1);
  leaf.base_colour_texture = scene.add_texture(leaf_texture("leaf", 64, {86, 140, 52}, options.seed));
  leaf.alpha_mode = AlphaMode::test;
  leaf.two_sided = true;
  Material lamp = plain("lamp", 0.1f, 0.1f, 0.1f);
  lamp.emissive = {2, 1.6f, 0.8f};
  const std::array materials{plain("grey", 0.5f, 0.5f, 0.5f), lamp, leaf};
  const std::array<glm::dvec3, 3> corners{glm::dvec3(-1.4, -1.0, -1.0), {-0.2, -0.6, 0}, {-1.0, -0.9, 1.0}};
  for (std::size_t i = 0; i < materials.size(); ++i) {
    Mesh mesh;
    add_quad(mesh, corners[i], {1.5, 0.2, 0}, {-0.1, 1.5, 0}, 1 / 1.5);
    scene.draw(scene.add_mesh(materials[i].name, mesh), materials[i].name, scene.add_material(materials[i]));
  }
  return scene.finish(drifting_camera(5), options.frames, options.width, options.height);
}

Capture spheres(const GenerateOptions& options) {
  constexpr int kSide = 5;
  SceneBuilder scene = small_scene("spheres", options);
  Mesh mesh;
  add_sphere(mesh, {0, 0, 0}, 0.42, 16);
  const Draw sphere = scene.add_mesh("sphere", mesh);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const std::string name = "sphere " + std::to_string(row) + " " + std::to_string(column);
      Material material = plain(name, 0.9f, 0.6f, 0.3f);
      material.metallic = static_cast<float>(row) / (kSide - 1);
      material.roughness = static_cast<float>(column) / (kSide - 1);
      scene.draw(sphere, name, scene.add_material(material), translation({column - 2.0, row - 2.0, 0}));
    }
  }
  scene.environment.point_lights = {{{-2, 2, 2}, {6, 6, 6}, 12}, {{2.5f, -1, 2.5f}, {3, 4, 6}, 12}};
  return scene.finish(drifting_camera(7), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
