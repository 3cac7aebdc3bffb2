// What the papers show of their own failures, rebuilt small.
#include <array>
#include <string>

#include "scenes/generate/hard_cases/case_parts.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_parts.hpp"

namespace subpixel::capture {
namespace {

std::uint32_t add_two_sided(SceneBuilder& scene, const std::string& name, const glm::vec3& colour, float roughness,
                            float metallic) {
  Material material;
  material.name = name;
  material.base_colour = {colour.r, colour.g, colour.b, 1};
  material.roughness = roughness;
  material.metallic = metallic;
  material.two_sided = true;
  return scene.add_material(material);
}

// Black and white cells of 4x4 texels.
Texture checker_texture(const std::string& name, std::uint32_t side) {
  Texture texture;
  texture.name = name;
  texture.srgb = true;
  texture.width = texture.height = side;
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::byte value{static_cast<std::uint8_t>((x / 4 + y / 4) % 2 == 0 ? 235 : 20)};
      for (int c = 0; c < 3; ++c) texture.bytes.push_back(value);
      texture.bytes.push_back(std::byte{255});
    }
  }
  return texture;
}

}  // namespace

// Crassin et al. 2016, figure 17 a: in every pixel the white stripes are in shadow and the black ones lit, so the mean
// albedo times the mean light is far from what is there. The slats that shade stand behind the camera, between it and
// the sun, which shines along the view.
Capture hard_shadow_albedo(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_shadow_albedo", options);
  scene.environment.sun = DirectionalLight{{0, 0, -1}, {4, 4, 4}, true};
  scene.environment.ambient = {0.02f, 0.02f, 0.02f};
  const double width = 0.5 * pixel_side(kDistance, options);
  const int count = static_cast<int>(2 * options.width);
  std::array<Mesh, 2> stripes;
  Mesh slats;
  for (int i = 0; i < count; ++i) {
    const int place = i - count / 2;
    const double left = (place + 0.3) * width;
    add_quad(stripes[i % 2 == 0 ? 0 : 1], {left, -1.2, 0}, {width, 0, 0}, {0, 2.4, 0});
    // Shadows on the upper half: below, white is lit, too. They are wider than the stripes by the shadow filter's
    // reach.
    if (i % 2 == 0) add_box(slats, {left - 0.3 * width, 0, 8}, {left + 1.3 * width, 1.3, 8.02});
  }
  const std::array materials{add_plain_material(scene, "white", {0.9, 0.9, 0.9}, 1),
                             add_plain_material(scene, "black", {0.02, 0.02, 0.02}, 1)};
  for (std::size_t i = 0; i < stripes.size(); ++i)
    scene.draw(scene.add_mesh("stripes", stripes[i]), "stripes", materials[i]);
  scene.draw(scene.add_mesh("slats", slats), "slats", materials[1]);
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Figure 17 b: bent hairs of 0.3 pixels with highlights along them, before a light wall.
Capture hard_hairs(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_hairs", options);
  Random random(options.seed);
  const double pixel = pixel_side(kDistance, options), side = options.height * pixel;
  Mesh wall, hairs;
  add_quad(wall, {-4, -3, -1}, {8, 0, 0}, {0, 6, 0});
  scene.draw(scene.add_mesh("wall", wall), "wall", add_plain_material(scene, "wall", {0.7, 0.7, 0.6}, 0.9));
  for (int i = 0; i < 90; ++i) {
    const glm::dvec3 root{random.between(-0.6, 0.6) * side, -0.55 * side, random.between(-0.3, 0.6)};
    const double lean = random.between(-0.4, 0.4), bend = random.between(-0.4, 0.4);
    std::array<glm::dvec3, 7> path;
    for (std::size_t k = 0; k < path.size(); ++k) {
      const double t = static_cast<double>(k) / 6;
      path[k] = root + side * glm::dvec3(lean * t + bend * t * t, 0.95 * t, 0.05 * t);
    }
    std::array<double, 7> radii{};
    radii.fill(0.15 * pixel);
    add_tube(hairs, path, radii, 3, false);
  }
  scene.draw(scene.add_mesh("hairs", hairs), "hairs", add_two_sided(scene, "hair", {0.08f, 0.05f, 0.03f}, 0.25f, 0));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Figure 17 c: square metal bars of a third of a pixel, so that each pixel's normals have two or three lobes.
Capture hard_railings(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_railings", options);
  scene.environment.sun = DirectionalLight{{0.7f, -0.3f, -0.6f}, {4, 4, 4}, false};
  const double pixel = pixel_side(kDistance, options);
  Mesh bars;
  for (int row = 0; row < 3; ++row) {
    const double bottom = (-0.42 + 0.28 * row) * options.height * pixel, top = bottom + 0.22 * options.height * pixel;
    const int count = static_cast<int>(options.width * 0.8 / 1.1);
    const double radius = (0.12 + 0.08 * row) * pixel, z = -0.2 * row;
    for (int i = 0; i < count; ++i) {
      const int place = i - count / 2;
      const double x = place * 1.1 * pixel;
      add_bar(bars, {x, bottom, z}, {x + 0.02, top, z}, radius, 4, false);
    }
    for (const double y : {bottom, top})
      add_bar(bars, {-0.4 * options.width * pixel, y, z}, {0.4 * options.width * pixel, y, z}, 2 * radius, 4, false);
  }
  scene.draw(scene.add_mesh("bars", bars), "bars", add_two_sided(scene, "metal", {0.8f, 0.8f, 0.85f}, 0.3f, 1));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Wang et al. 2015, figure 10 a: a finely meshed wall whose texture changes within a pixel. Merged fragments mix what
// lies in different cells.
Capture hard_blurred_texture(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_blurred_texture", options);
  const double pixel = pixel_side(kDistance, options);
  Material checker;
  checker.name = "checker";
  checker.base_colour_texture = scene.add_texture(checker_texture("checker", 64));
  checker.roughness = 0.9f;
  Mesh wall;
  const int columns = static_cast<int>(options.width / 2), rows = static_cast<int>(options.height / 2);
  const double cell = 1.7 * pixel;
  const int middle_column = columns / 2, middle_row = rows / 2;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      add_quad(wall, {(column - middle_column) * cell, (row - middle_row) * cell, 0}, {cell, 0, 0}, {0, cell, 0},
               0.05 / pixel);
  scene.draw(scene.add_mesh("wall", wall), "wall", scene.add_material(checker), rotation({0, 0, 1}, 11 * kPi / 180));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Figure 10 b: walls that meet at 170 degrees, one side lit by a sun that grazes it, the other not.
Capture hard_small_angle(const GenerateOptions& options) {
  constexpr double kDistance = 4, kAngle = 5 * kPi / 180;
  SceneBuilder scene = lit_case("hard_small_angle", options);
  scene.environment.sun = DirectionalLight{
      {-static_cast<float>(cosine(kAngle)), 0, -static_cast<float>(sine(kAngle))}, {24, 24, 24}, false};
  const double pixel = pixel_side(kDistance, options), width = 3.3 * pixel;
  const int count = static_cast<int>(options.width / 4);
  Mesh walls;
  for (int i = 0; i < count; ++i) {
    const double depth = width * sine(kAngle) / cosine(kAngle);
    const bool rising = i % 2 == 0;
    const int place = i - count / 2;
    add_quad(walls, {place * width, -1.1, rising ? 0 : depth}, {width, 0, rising ? depth : -depth}, {0, 2.2, 0});
  }
  scene.draw(scene.add_mesh("walls", walls), "walls", add_plain_material(scene, "plaster", {0.7, 0.7, 0.7}, 1),
             rotation({0, 0, 1}, 7 * kPi / 180));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Figure 10 c: dark frames of 0.25 pixels close before a white wall, which pixels show more of.
Capture hard_window_frame(const GenerateOptions& options) {
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_window_frame", options);
  const double pixel = pixel_side(kDistance, options);
  Mesh wall, frames;
  add_quad(wall, {-4, -3, 0}, {8, 0, 0}, {0, 6, 0});
  scene.draw(scene.add_mesh("wall", wall), "wall", add_plain_material(scene, "white", {0.9, 0.9, 0.9}, 0.9));
  const double side = 9.3 * pixel, bar = 0.25 * pixel;
  const int columns = static_cast<int>(options.width / 10), rows = static_cast<int>(options.height / 10);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const glm::dvec3 corner((column - 0.5 * columns) * side, (row - 0.5 * rows) * side, 0);
      const double size = 0.8 * side;
      for (const double at : {0.0, 0.5, 1.0}) {
        const double from = at * size;
        add_box(frames, corner + glm::dvec3(from, 0, 0.01), corner + glm::dvec3(from + bar, size, 0.03));
        add_box(frames, corner + glm::dvec3(0, from, 0.01), corner + glm::dvec3(size, from + bar, 0.03));
      }
    }
  }
  scene.draw(scene.add_mesh("frames", frames), "frames", add_plain_material(scene, "dark", {0.05, 0.04, 0.03}, 0.5),
             rotation({0, 0, 1}, 4 * kPi / 180));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
