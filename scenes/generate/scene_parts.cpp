#include "scenes/generate/scene_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <utility>

#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

std::uint32_t scaled_count(std::uint32_t count, double density) {
  return static_cast<std::uint32_t>(std::max(1.0, std::floor(count * density + 0.5)));
}

std::vector<double> every(double first, double step, double last) {
  std::vector<double> places;
  for (std::uint32_t i = 0; first + step * i <= last; ++i) places.push_back(first + step * i);
  return places;
}

std::uint32_t add_plain_material(SceneBuilder& scene, const std::string& name, const glm::dvec3& colour,
                                 double roughness, double metallic) {
  Material material;
  material.name = name;
  material.base_colour = {static_cast<float>(colour.x), static_cast<float>(colour.y), static_cast<float>(colour.z), 1};
  material.roughness = static_cast<float>(roughness);
  material.metallic = static_cast<float>(metallic);
  return scene.add_material(material);
}

std::uint32_t add_lamp_glass(SceneBuilder& scene, const glm::vec3& colour, const glm::vec3& emissive) {
  Material lamp;
  lamp.name = "lamp glass";
  lamp.base_colour = {colour.x, colour.y, colour.z, 1};
  lamp.emissive = {emissive.x, emissive.y, emissive.z};
  return scene.add_material(lamp);
}

void add_grid_triangles(Mesh& mesh, std::uint32_t rows, std::uint32_t columns) {
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
      mesh.add_triangle(a, a + 1, b + 1);
      mesh.add_triangle(a, b + 1, b);
    }
}

void draw_floor(SceneBuilder& scene, const std::string& name, const glm::dvec3& low, const glm::dvec3& high,
                double tile_m, double roughness, std::uint64_t seed) {
  Material material;
  material.name = name;
  material.base_colour_texture = scene.add_texture(noise_texture(name, 512, 24, low, high, seed));
  material.roughness = static_cast<float>(roughness);
  Mesh mesh;
  add_quad(mesh, {-60, 0, 60}, {120, 0, 0}, {0, 0, -120}, 1 / tile_m);
  scene.draw(scene.add_mesh(name, mesh), name, scene.add_material(material));
}

void scatter_lights(SceneBuilder& scene, const glm::dvec3& low, const glm::dvec3& high, double intensity, double range,
                    Random& random) {
  for (std::uint32_t i = 0; i < kSceneLights; ++i) {
    const double x = random.between(low.x, high.x);
    const double y = random.between(low.y, high.y);
    const double z = random.between(low.z, high.z);
    const double warm = random.unit();
    PointLight light;
    light.position = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    light.intensity = {static_cast<float>(intensity * (0.6 + 0.4 * warm)), static_cast<float>(intensity * 0.7),
                       static_cast<float>(intensity * (1.0 - 0.6 * warm))};
    light.range = static_cast<float>(range);
    scene.environment.point_lights.push_back(light);
  }
}

std::uint32_t add_masonry(SceneBuilder& scene, const std::string& name, const BrickPattern& pattern, double depth,
                          float roughness, std::uint64_t seed) {
  Material material;
  material.name = name;
  material.base_colour_texture = scene.add_texture(brick_texture(name, 512, pattern, seed));
  material.normal_texture = scene.add_texture(brick_normal_texture(name + " normals", 512, pattern, depth, seed));
  material.roughness = roughness;
  return scene.add_material(material);
}

Mesh arched_wall(const ArchShape& shape) {
  Mesh mesh;
  const double middle = -shape.bay / 2;
  const auto rim = [&](std::uint32_t i) {
    const double angle = kPi * i / shape.steps;
    return glm::dvec2(middle + shape.radius * cosine(angle), shape.springing + shape.radius * sine(angle));
  };
  const double half = shape.thickness / 2;
  for (std::uint32_t i = 0; i < shape.steps; ++i) {
    const glm::dvec2 a = rim(i);
    const glm::dvec2 b = rim(i + 1);
    // Above the rim to the floor of the gallery, on both faces.
    for (const double side : {1.0, -1.0}) {
      const glm::dvec3 normal(side, 0, 0);
      const std::array<glm::dvec3, 4> corners{glm::dvec3(side * half, a.y, a.x),
                                              {side * half, b.y, b.x},
                                              {side * half, shape.top, b.x},
                                              {side * half, shape.top, a.x}};
      std::array<std::uint32_t, 4> v{};
      for (std::size_t k = 0; k < 4; ++k)
        v[k] = mesh.add_vertex(corners[k], normal, {-side * corners[k].z, -corners[k].y});
      if (side < 0) std::swap(v[1], v[3]);
      mesh.add_triangle(v[0], v[1], v[2]);
      mesh.add_triangle(v[0], v[2], v[3]);
    }
    // The underside of the opening, smooth.
    const auto inward = [&](const glm::dvec2& p) {
      return glm::normalize(glm::dvec3(0, shape.springing - p.y, middle - p.x));
    };
    const double u = shape.radius * kPi / shape.steps;
    const std::uint32_t p = mesh.add_vertex({-half, a.y, a.x}, inward(a), {i * u, 0});
    const std::uint32_t q = mesh.add_vertex({half, a.y, a.x}, inward(a), {i * u, shape.thickness});
    const std::uint32_t r = mesh.add_vertex({half, b.y, b.x}, inward(b), {(i + 1) * u, shape.thickness});
    const std::uint32_t s = mesh.add_vertex({-half, b.y, b.x}, inward(b), {(i + 1) * u, 0});
    mesh.add_triangle(p, s, r);
    mesh.add_triangle(p, r, q);
  }
  // Between the rim's ends and the columns' middles.
  const double pier = shape.bay / 2 - shape.radius;
  add_box(mesh, {-half, shape.springing, -pier}, {half, shape.top, 0});
  add_box(mesh, {-half, shape.springing, -shape.bay}, {half, shape.top, -shape.bay + pier});
  return mesh;
}

Mesh boxed(const glm::dvec3& low, const glm::dvec3& high, double uv_scale) {
  Mesh mesh;
  add_box(mesh, low, high, uv_scale);
  compute_tangents(mesh);
  return mesh;
}

glm::dvec3 random_direction(Random& random) {
  const double height = random.between(-1, 1);
  const double turn = random.between(0, 2 * kPi);
  const double girth = std::sqrt(std::max(0.0, 1 - height * height));
  return {girth * cosine(turn), height, girth * sine(turn)};
}

}  // namespace subpixel::capture
