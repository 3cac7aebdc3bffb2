#include "scenes/generate/grass_blades.hpp"

#include <glm/geometric.hpp>

#include "scenes/generate/textures.hpp"

namespace subpixel::capture {

void add_blade(Mesh& mesh, const BladeShape& shape, Random& random) {
  const double turn = random.between(0, 2 * kPi);
  const glm::dvec3 root{random.between(-0.5, 0.5) * shape.patch_m, -0.02, random.between(-0.5, 0.5) * shape.patch_m};
  const glm::dvec3 lean(cosine(turn), 0, sine(turn));
  const glm::dvec3 across(-sine(turn), 0, cosine(turn));
  const double height = shape.height_m * random.between(0.6, 1.4);
  const double width = shape.width_m * random.between(0.7, 1.3);
  const double bend = random.between(0.1, 1.1);  // radians between root's and tip's directions, half of it
  glm::dvec3 at = root;
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  for (std::uint32_t i = 0; i <= shape.segments; ++i) {
    const double t = static_cast<double>(i) / shape.segments;
    const double angle = bend * 2 * t * t;
    const glm::dvec3 along = glm::dvec3(0, cosine(angle), 0) + lean * sine(angle);
    const glm::dvec3 normal = glm::normalize(glm::cross(across, along));
    if (i == shape.segments) {
      const std::uint32_t tip = mesh.add_vertex(at, normal, {0.5, 0});
      mesh.add_triangle(left, right, tip);
      break;
    }
    const glm::dvec3 half = across * (0.5 * width * (1 - 0.75 * t * t));
    const std::uint32_t new_left = mesh.add_vertex(at - half, normal, {0, 1 - t});
    const std::uint32_t new_right = mesh.add_vertex(at + half, normal, {1, 1 - t});
    if (i > 0) {
      mesh.add_triangle(left, right, new_right);
      mesh.add_triangle(left, new_right, new_left);
    }
    left = new_left;
    right = new_right;
    at += along * (height / shape.segments);
  }
}

std::uint32_t add_grass_material(SceneBuilder& scene, const std::string& name, const glm::dvec3& root,
                                 const glm::dvec3& tip) {
  Material material;
  material.name = name;
  material.base_colour_texture = scene.add_texture(blade_texture(name, 16, 64, root, tip));
  material.roughness = 0.55f;
  material.two_sided = true;
  return scene.add_material(material);
}

}  // namespace subpixel::capture
