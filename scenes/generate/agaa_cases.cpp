// Figure 17 of Crassin et al. 2016 as captures: what filtering over one aggregate gets wrong, as the paper says itself.
#include <array>
#include <cmath>
#include <string>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scene_parts.hpp"
#include "scenes/generate/scenes.hpp"

namespace subpixel::capture {
namespace {

CameraPath drifting_camera() {
  return CameraPath({{0, {0, 0, 5}, {0, 0, 0}, 40}, {10, {0.5, 0.25, 5}, {0.5, 0.25, 0}, 40}});
}

}  // namespace

// (a) Sunlit leaves before a red wall that stands in shadow: colour and shadow go together, so means of both,
// multiplied, light the wall's red.
Capture agaa_correlation(const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata("agaa_correlation", options));
  scene.environment.sun = DirectionalLight{{0.1f, -0.95f, -0.3f}, {6, 6, 6}, true};
  scene.environment.ambient = {0.08f, 0.08f, 0.08f};
  Mesh wall;
  add_quad(wall, {-6, -4, -1.2}, {12, 0, 0}, {0, 8, 0});
  scene.draw(scene.add_mesh("wall", wall), "wall", add_plain_material(scene, "red wall", {0.8, 0.05, 0.03}, 1));
  Mesh roof;
  add_box(roof, {-6, 2.2, -1.2}, {6, 2.3, -0.2});
  scene.draw(scene.add_mesh("roof", roof), "roof", add_plain_material(scene, "roof", {0.3, 0.3, 0.3}, 1));
  Random random(options.seed);
  Mesh leaves;
  for (std::uint32_t i = 0; i < scaled_count(5000, options.density); ++i) {
    const glm::dvec3 centre{random.between(-2.2, 2.2), random.between(-1.4, 1.4), random.between(0, 0.4)};
    const double turn = random.between(0, 2 * kPi), lean = random.between(0.3, 1);
    const glm::dvec3 right{0.05 * cosine(turn), 0.05 * sine(turn), 0};
    const glm::dvec3 up{-0.014 * sine(turn), 0.014 * cosine(turn), -0.014 * lean};
    add_quad(leaves, centre, right, up);
  }
  Material leaf;
  leaf.name = "leaves";
  leaf.base_colour = {0.35f, 0.5f, 0.05f, 1};
  leaf.roughness = 0.9f;
  leaf.two_sided = true;
  scene.draw(scene.add_mesh("leaves", leaves), "leaves", scene.add_material(leaf));
  return scene.finish(drifting_camera(), options.frames, options.width, options.height);
}

// (b) Thin shiny hairs side by side: the normals of a pixel lie on an arc, which a mean's length alone widens all
// around.
Capture agaa_hairs(const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata("agaa_hairs", options));
  scene.environment.sun = DirectionalLight{{-0.3f, -0.5f, -0.8f}, {3, 3, 3}, false};
  Random random(options.seed);
  Mesh hairs;
  for (std::uint32_t i = 0; i < scaled_count(2000, options.density); ++i) {
    const double x = random.between(-2.4, 2.4), z = random.between(-0.3, 0.3), bend = random.between(0.15, 0.3);
    std::array<glm::dvec3, 12> path;
    for (std::size_t k = 0; k < path.size(); ++k) {
      const double y = 1.5 - 3.0 * static_cast<double>(k) / 11;
      path[k] = {x + bend * sine(1.5 * y + 0.5 * x), y, z + bend * cosine(1.2 * y)};
    }
    const std::array<double, 12> radii{0.003, 0.003, 0.003, 0.003, 0.003, 0.003,
                                       0.003, 0.003, 0.003, 0.003, 0.003, 0.003};
    add_tube(hairs, path, radii, 6, false);
  }
  scene.draw(scene.add_mesh("hairs", hairs), "hairs", add_plain_material(scene, "hair", {0.5, 0.3, 0.12}, 0.3, 0.6));
  return scene.finish(drifting_camera(), options.frames, options.width, options.height);
}

// (c) Railings of square bars: two faces of each show, and a mean of their normals faces where nothing does.
Capture agaa_railings(const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata("agaa_railings", options));
  scene.environment.sun = DirectionalLight{{0, -0.4f, -1}, {3, 3, 3}, false};
  scene.environment.ambient = {0.1f, 0.1f, 0.1f};
  Mesh bars;
  const glm::dmat4 edge_on = rotation({0, 1, 0}, kPi / 4);
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < 300; ++i) {
      Mesh bar;
      add_box(bar, {-0.004, -1.6, -0.004}, {0.004, 1.6, 0.004});
      append(bars, bar, translation({0.017 * (i - 150) + 0.003 * row, 0, -0.5 * row}) * edge_on);
    }
  scene.draw(scene.add_mesh("bars", bars), "bars", add_plain_material(scene, "iron", {0.6, 0.6, 0.6}, 0.3, 1),
             rotation({0, 0, 1}, 7 * kPi / 180));
  return scene.finish(drifting_camera(), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
