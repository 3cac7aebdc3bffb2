// Hard cases of edges and coverage.
#include <array>
#include <glm/geometric.hpp>
#include <string>

#include "scenes/generate/hard_cases/case_parts.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_parts.hpp"

namespace subpixel::capture {

// Triangles a million times as long as wide: some reach over the guard band and are a tenth of a pixel wide, others
// end within the frame and are narrower than a snapping step.
Capture hard_slivers(const GenerateOptions& options) {
  constexpr int kDirections = 24;
  constexpr double kDistance = 4, kAspect = 1e6;
  SceneBuilder scene = dark_case("hard_slivers", options);
  Random random(options.seed);
  const double pixel = pixel_side(kDistance, options);
  Mesh mesh;
  for (int i = 0; i < 2 * kDirections; ++i) {
    const double angle = (i + 0.3) * kPi / kDirections;
    const double length = (i % 2 == 0 ? 1e5 : 0.7 * options.height) * pixel;
    const double x = random.between(-0.4, 0.4) * options.width * pixel;
    const double y = random.between(-0.4, 0.4) * options.height * pixel;
    const glm::dvec3 along(cosine(angle), sine(angle), 0), across(-along.y, along.x, 0), middle(x, y, 0);
    const double half_width = 0.5 * length / kAspect;
    const std::uint32_t a = mesh.add_vertex(middle - 0.5 * length * along - half_width * across, {0, 0, 1}, {0, 0});
    const std::uint32_t b = mesh.add_vertex(middle + 0.5 * length * along, {0, 0, 1}, {0, 0});
    const std::uint32_t c = mesh.add_vertex(middle - 0.5 * length * along + half_width * across, {0, 0, 1}, {0, 0});
    mesh.add_triangle(a, b, c);
  }
  scene.draw(scene.add_mesh("slivers", mesh), "slivers", add_emitting(scene, "white", {1, 1, 1}));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

Capture hard_subpixel(const GenerateOptions& options) {
  constexpr int kPerPixel = 60, kMaterials = 6;
  constexpr double kDistance = 4;
  SceneBuilder scene = lit_case("hard_subpixel", options);
  Random random(options.seed);
  const double pixel = pixel_side(kDistance, options);
  const int columns = static_cast<int>(options.width) / 2, rows = static_cast<int>(options.height) / 2;
  std::array<Mesh, kMaterials> meshes;
  for (int cell = 0; cell < columns * rows; ++cell) {
    const int column = cell % columns - columns / 2, row = cell / columns - rows / 2;
    const glm::dvec3 corner(column * pixel, row * pixel, 0);
    for (int i = 0; i < kPerPixel; ++i) {
      Mesh& mesh = meshes[random.below(kMaterials)];
      const double size = random.between(0.1, 0.7) * pixel;
      const glm::dvec3 centre =
          corner + glm::dvec3{random.unit() * pixel, random.unit() * pixel, random.between(-4, 4) * pixel};
      const glm::dvec3 normal = glm::normalize(random_direction(random) + glm::dvec3(0, 0, 1.1));
      const double turn = random.between(0, 2 * kPi);
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double angle = turn + static_cast<double>(k) * 2 * kPi / 3;
        const glm::dvec3 out(cosine(angle), sine(angle), 0);
        corners[k] = mesh.add_vertex(centre + size * (out - normal * glm::dot(out, normal)), normal, {0, 0});
      }
      mesh.add_triangle(corners[0], corners[1], corners[2]);
    }
  }
  for (int m = 0; m < kMaterials; ++m) {
    const glm::dvec3 colour(m % 2 == 0 ? 0.8 : 0.1, m % 3 == 0 ? 0.7 : 0.2, m < 3 ? 0.1 : 0.6);
    const std::string name = "chips " + std::to_string(m);
    scene.draw(scene.add_mesh(name, meshes[static_cast<std::size_t>(m)]), name,
               add_plain_material(scene, name, colour, 0.3 + 0.1 * m));
  }
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// A fan around a point off the sample grid, and a sphere.
Capture hard_shared_edges(const GenerateOptions& options) {
  constexpr int kSpokes = 61;
  constexpr double kDistance = 4;
  SceneBuilder scene = dark_case("hard_shared_edges", options);
  const double pixel = pixel_side(kDistance, options), radius = 0.22 * options.width * pixel;
  const glm::dvec3 centre(-0.25 * options.width * pixel + 0.013 * pixel, 0.217 * pixel, 0);
  Mesh fan;
  fan.add_vertex(centre, {0, 0, 1}, {0, 0});
  for (int i = 0; i < kSpokes; ++i) {
    const double angle = i * 2 * kPi / kSpokes;
    fan.add_vertex(centre + radius * glm::dvec3(cosine(angle), sine(angle), 0), {0, 0, 1}, {0, 0});
  }
  for (std::uint32_t i = 0; i < kSpokes; ++i) fan.add_triangle(0, 1 + i, 1 + (i + 1) % kSpokes);
  Mesh sphere;
  add_sphere(sphere, {-centre.x, 0, 0}, radius, 14);
  const std::uint32_t white = add_emitting(scene, "white", {1, 1, 1});
  scene.draw(scene.add_mesh("fan", fan), "fan", white);
  scene.draw(scene.add_mesh("sphere", sphere), "sphere", white);
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

// Columns of 7, 5, 3, ... rows side by side: the corners of one lie on the edges of the next. A bright sky behind a
// dark wall shows every crack.
Capture hard_t_junctions(const GenerateOptions& options) {
  constexpr std::array kRows{7, 5, 3, 8, 6, 11};
  constexpr double kDistance = 4;
  SceneBuilder scene = dark_case("hard_t_junctions", options);
  scene.environment.sky = {1, 1, 1};
  const double pixel = pixel_side(kDistance, options);
  const double side = 0.14 * options.width * pixel, height = 0.7 * options.height * pixel;
  Mesh wall;
  for (std::size_t column = 0; column < kRows.size(); ++column) {
    const double left = (static_cast<double>(column) - 0.5 * static_cast<double>(kRows.size())) * side;
    const double cell = height / kRows[column];
    for (int row = 0; row < kRows[column]; ++row)
      add_quad(wall, {left, row * cell - height / 2, 0}, {side, 0, 0}, {0, cell, 0});
  }
  scene.draw(scene.add_mesh("wall", wall), "wall", add_emitting(scene, "grey", {0.25f, 0.25f, 0.25f}),
             rotation({0, 0, 1}, 7 * kPi / 180));
  return scene.finish(case_camera(kDistance), options.frames, options.width, options.height);
}

Capture hard_fullscreen(const GenerateOptions& options) {
  SceneBuilder scene = dark_case("hard_fullscreen", options);
  Mesh mesh;
  mesh.add_vertex({-90, -70, 0}, {0, 0, 1}, {0, 0});
  mesh.add_vertex({100, -80, 0}, {0, 0, 1}, {0, 0});
  mesh.add_vertex({3, 120, 0}, {0, 0, 1}, {0, 0});
  mesh.add_triangle(0, 1, 2);
  scene.draw(scene.add_mesh("triangle", mesh), "triangle", add_emitting(scene, "violet", {0.5f, 0.25f, 1}));
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
