#include "scenes/generate/scene_parts.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

std::uint32_t scaled_count(std::uint32_t count, double density) {
  return static_cast<std::uint32_t>(std::max(1.0, std::floor(count * density + 0.5)));
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

glm::dvec3 random_direction(Random& random) {
  const double height = random.between(-1, 1);
  const double turn = random.between(0, 2 * kPi);
  const double girth = std::sqrt(std::max(0.0, 1 - height * height));
  return {girth * cosine(turn), height, girth * sine(turn)};
}

}  // namespace subpixel::capture
