#include "scenes/generate/hard_cases/case_parts.hpp"

#include <glm/geometric.hpp>

#include "scenes/generate/scene_metadata.hpp"

namespace subpixel::capture {

SceneBuilder dark_case(const std::string& name, const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata(name, options));
  scene.environment.ambient = {0, 0, 0};
  scene.environment.sky = {0, 0, 0};
  return scene;
}

SceneBuilder lit_case(const std::string& name, const GenerateOptions& options) {
  SceneBuilder scene(generated_metadata(name, options));
  scene.environment.sun = DirectionalLight{{0.5f, -0.6f, -0.7f}, {3, 3, 3}, false};
  scene.environment.ambient = {0.1f, 0.1f, 0.12f};
  return scene;
}

std::uint32_t add_emitting(SceneBuilder& scene, const std::string& name, const Float3& radiance) {
  Material material;
  material.name = name;
  material.base_colour = {0, 0, 0, 1};
  material.emissive = radiance;
  return scene.add_material(material);
}

CameraPath case_camera(double distance) {
  return CameraPath({{0, {0, 0, distance}, {0, 0, 0}, 45}, {10, {0.5, 0.25, distance}, {0.5, 0.25, 0}, 45}});
}

double pixel_side(double distance, const GenerateOptions& options) {
  constexpr double kHalfAngle = 22.5 * kPi / 180;
  return 2 * distance * sine(kHalfAngle) / cosine(kHalfAngle) / options.height;
}

void add_strip(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double width) {
  const glm::dvec3 along = to - from;
  const glm::dvec3 across = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), along)) * width;
  add_quad(mesh, from - across * 0.5, along, across);
}

}  // namespace subpixel::capture
