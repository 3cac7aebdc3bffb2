// A tangle of metal tubes: each winds through a few random points, some thick, many thin as wires.
#include <array>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scene_parts.hpp"
#include "scenes/generate/scenes.hpp"

namespace subpixel::capture {
namespace {

Mesh winding_tube(const TubesParameters& parameters, double radius, Random& random) {
  constexpr std::uint32_t kPoints = 6;
  std::vector<CameraKey> keys;  // the camera's spline gives the tube's middle line
  glm::dvec3 at{random.between(-2.2, 2.2), random.between(0.2, 0.9), random.between(-2.2, 1.2)};
  glm::dvec3 towards = glm::normalize(random_direction(random) + glm::dvec3(0, 0.4, 0));
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    keys.push_back({static_cast<double>(i), at, {0, 0, 0}, 0});
    at += towards * random.between(0.5, 0.9);
    const glm::dvec3 home = glm::dvec3(0, 1.25, -0.4) - at;  // keeps the tangle together
    towards = glm::normalize(towards + 0.9 * random_direction(random) + 0.35 * home);
    at.y = std::max(at.y, radius + 0.02);
  }
  const CameraPath line(keys);
  std::vector<glm::dvec3> path;
  for (std::uint32_t i = 0; i <= parameters.rings; ++i) {
    path.push_back(line.at(static_cast<double>(i) * (kPoints - 1) / parameters.rings).eye);
    path.back().y = std::max(path.back().y, radius);
  }
  Mesh mesh;
  add_tube(mesh, path, std::vector<double>(path.size(), radius), parameters.sides, true);
  return mesh;
}

}  // namespace

Capture tubes(const GenerateOptions& options, const TubesParameters& parameters) {
  SceneBuilder scene(generated_metadata("tubes", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{0.45f, -0.7f, -0.55f}, {3.2f, 3.1f, 2.9f}, true};
  scatter_lights(scene, {-3.5, 0.5, -2.5}, {3.5, 3.5, 4}, 1.6, 5, random);
  draw_floor(scene, "concrete", {104, 104, 106}, {138, 136, 132}, 3, 0.55, options.seed + 1);
  const std::array materials{add_plain_material(scene, "steel", {0.62, 0.62, 0.64}, 0.22, 1),
                             add_plain_material(scene, "copper", {0.93, 0.56, 0.42}, 0.28, 1),
                             add_plain_material(scene, "brass", {0.87, 0.70, 0.36}, 0.18, 1),
                             add_plain_material(scene, "black iron", {0.16, 0.16, 0.17}, 0.45, 1),
                             add_plain_material(scene, "blue lacquer", {0.06, 0.14, 0.42}, 0.25, 0)};
  const std::uint32_t count = scaled_count(parameters.tubes, options.density);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double thick = random.unit();
    const double radius = thick < 0.55 ? random.between(0.004, 0.012) : random.between(0.015, 0.055);
    const std::string name = "tube " + std::to_string(i);
    const std::uint32_t material = materials[random.below(static_cast<std::uint32_t>(materials.size()))];
    scene.draw(scene.add_mesh(name, winding_tube(parameters, radius, random)), name, material);
  }
  const CameraPath path({{0, {-0.6, 1.7, 4.4}, {0, 1.2, -0.3}, 48},
                         {4, {0.6, 1.75, 4.2}, {0.05, 1.2, -0.3}, 48},
                         {10, {2.4, 1.9, 3.4}, {0.1, 1.2, -0.3}, 48}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
