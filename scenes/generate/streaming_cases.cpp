// Figures 3 and 8 of Kerzner and Salvi 2014 as captures: where each condition of the merge metric is what keeps two
// features apart, and where all three together still don't.
#include <array>
#include <cmath>
#include <string>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scenes.hpp"

namespace subpixel::capture {
namespace {

// Edges run at 7 degrees to the pixel rows and columns, so that they cross pixels in all ways.
constexpr double kTilt = 7 * kPi / 180;

SceneBuilder lit_from_the_camera(const std::string& name, const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata(name, options));
  scene.environment.sun = DirectionalLight{{0, 0, -1}, {3, 3, 3}, false};
  return scene;
}

std::uint32_t add_plain(SceneBuilder& scene, const std::string& name, float grey) {
  Material material;
  material.name = name;
  material.base_colour = {grey, grey, grey, 1};
  material.roughness = 1;
  return scene.add_material(material);
}

CameraPath drifting_camera(double distance) {
  return CameraPath({{0, {0, 0, distance}, {0, 0, 0}, 45}, {10, {0.5, 0.25, distance}, {0.5, 0.25, 0}, 45}});
}

// Strips side by side along x, folded against each other: each faces `angle` away from +z, left and right in turn.
// Strip i goes to mesh i % 2.
std::array<Mesh, 2> folded_strips(int count, double width, double height, double angle) {
  std::array<Mesh, 2> meshes;
  const double depth = width * sine(angle) / cosine(angle);
  for (int i = 0; i < count; ++i) {
    const double left = (i - count / 2.0) * width;
    const bool rising = i % 2 == 0;
    add_quad(meshes[i % 2 == 0 ? 0 : 1], {left, -height / 2, rising ? 0 : depth}, {width, 0, rising ? depth : -depth},
             {0, height, 0});
  }
  return meshes;
}

}  // namespace

// Steep pleats: where two faces meet, a mean of their normals faces the light that each turns away from.
Capture streaming_normals(const GenerateOptions& options) {
  SceneBuilder scene = lit_from_the_camera("streaming_normals", options);
  const std::uint32_t material = add_plain(scene, "pleats", 0.6f);
  for (const Mesh& mesh : folded_strips(24, 0.16, 3, 68 * kPi / 180))
    scene.draw(scene.add_mesh("pleats", mesh), "pleats", material, rotation({0, 0, 1}, kTilt));
  return scene.finish(drifting_camera(5), options.frames, options.width, options.height);
}

// White slats before a dark wall, drawn before it: the wall's small triangles leave pixels half covered by a slat to
// both.
Capture streaming_depth(const GenerateOptions& options) {
  constexpr int kColumns = 240, kRows = 150;
  constexpr double kCell = 0.022;
  SceneBuilder scene = lit_from_the_camera("streaming_depth", options);
  Mesh slats;
  for (int i = 0; i < 16; ++i) add_quad(slats, {0.16 * (i - 8), -0.9, 0}, {0.045, 0, 0}, {0, 1.8, 0});
  scene.draw(scene.add_mesh("slats", slats), "slats", add_plain(scene, "slats", 0.8f), rotation({0, 0, 1}, kTilt));
  Mesh wall;
  constexpr int kMiddleColumn = kColumns / 2, kMiddleRow = kRows / 2;
  for (int row = 0; row <= kRows; ++row)
    for (int column = 0; column <= kColumns; ++column)
      wall.add_vertex({(column - kMiddleColumn) * kCell, (row - kMiddleRow) * kCell, -2}, {0, 0, 1}, {0, 0});
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t corner = row * (kColumns + 1) + column, above = corner + kColumns + 1;
      wall.add_triangle(corner, corner + 1, above + 1);
      wall.add_triangle(corner, above + 1, above);
    }
  }
  scene.draw(scene.add_mesh("wall", wall), "wall", add_plain(scene, "wall", 0.02f));
  return scene.finish(drifting_camera(5), options.frames, options.width, options.height);
}

// Mats on a floor seen at a grazing angle: in one pixel both reach over the same depths, and face the same way.
Capture streaming_coverage(const GenerateOptions& options) {
  SceneBuilder scene = lit_from_the_camera("streaming_coverage", options);
  scene.environment.sun = DirectionalLight{{0, -1, 0}, {3, 3, 3}, false};
  Mesh floor;
  add_quad(floor, {-30, 0, 0}, {60, 0, 0}, {0, 0, -40});
  scene.draw(scene.add_mesh("floor", floor), "floor", add_plain(scene, "floor", 0.05f));
  Mesh mats;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 12; ++column)
      add_quad(mats, {1.2 * (column - 6) + 0.1 * row, 0.008, -2.5 - 1.6 * row}, {0.7, 0, 0.05}, {0, 0, -0.9});
  scene.draw(scene.add_mesh("mats", mats), "mats", add_plain(scene, "mats", 0.8f));
  const CameraPath path({{0, {0, 0.3, 0}, {0, 0.1, -5}, 45}, {10, {0.5, 0.3, 0}, {0.5, 0.1, -5}, 45}});
  return scene.finish(path, options.frames, options.width, options.height);
}

// Light grey strips beside black ones, 30 degrees apart: near enough to merge with the paper's 45 degrees (figure 8).
Capture streaming_angle(const GenerateOptions& options) {
  SceneBuilder scene = lit_from_the_camera("streaming_angle", options);
  const std::array<Mesh, 2> meshes = folded_strips(20, 0.19, 3, 15 * kPi / 180);
  const std::array materials{add_plain(scene, "light grey", 0.7f), add_plain(scene, "black", 0.01f)};
  for (std::size_t i = 0; i < meshes.size(); ++i)
    scene.draw(scene.add_mesh("strips", meshes[i]), "strips", materials[i], rotation({0, 0, 1}, kTilt));
  return scene.finish(drifting_camera(5), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
