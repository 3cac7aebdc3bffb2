// A ball of fur. Fibres stand in clumps, a few different clumps placed many times; they bend the way they would hang.
#include <cmath>
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

constexpr std::uint32_t kVariants = 6;
constexpr double kBallHeight_m = 1.4;  // of its centre above the floor
constexpr double kClumpSide_m = 0.09;

// Roots around the origin, growing along +z and bending towards +x.
Mesh clump(const FurParameters& parameters, Random& random) {
  Mesh mesh;
  for (std::uint32_t f = 0; f < parameters.fibres_per_clump; ++f) {
    const double length = parameters.length_m * random.between(0.7, 1.15);
    const double bend = random.between(0.9, 1.7);
    const double sideways = random.between(-0.35, 0.35);
    glm::dvec3 at{random.between(-0.5, 0.5) * kClumpSide_m, random.between(-0.5, 0.5) * kClumpSide_m, -0.01};
    std::vector<glm::dvec3> path;
    std::vector<double> radii;
    for (std::uint32_t s = 0; s <= parameters.segments; ++s) {
      const double t = static_cast<double>(s) / parameters.segments;
      path.push_back(at);
      radii.push_back(parameters.radius_m * (1 - 0.85 * t));
      const double angle = bend * t;
      at += glm::normalize(glm::dvec3(sine(angle), sideways * t, cosine(angle))) * (length / parameters.segments);
    }
    add_tube(mesh, path, radii, 3, false);
  }
  return mesh;
}

}  // namespace

Capture fur(const GenerateOptions& options, const FurParameters& parameters) {
  SceneBuilder scene(generated_metadata("fur", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{-0.55f, -0.62f, -0.56f}, {3.4f, 3.2f, 2.9f}, true};
  scatter_lights(scene, {-3, 0.4, -1}, {3, 3.2, 3}, 0.9, 3.5, random);
  draw_floor(scene, "floor", {120, 112, 100}, {158, 148, 132}, 4, 0.8, options.seed + 1);

  const glm::dvec3 centre(0, kBallHeight_m, 0);
  Mesh skin;
  add_sphere(skin, centre, 1, 40);
  scene.draw(scene.add_mesh("skin", skin), "skin", add_plain_material(scene, "skin", {0.11, 0.06, 0.03}, 0.9));

  const std::uint32_t hair[] = {add_plain_material(scene, "dark hair", {0.16, 0.075, 0.03}, 0.38),
                                add_plain_material(scene, "brown hair", {0.30, 0.16, 0.07}, 0.35),
                                add_plain_material(scene, "light hair", {0.52, 0.36, 0.2}, 0.32)};
  std::vector<std::vector<glm::dmat4>> places(kVariants);
  const std::uint32_t clumps = scaled_count(parameters.clumps, options.density);
  for (std::uint32_t i = 0; i < clumps; ++i) {
    // Fibonacci lattice: even over the sphere for any count.
    const double height = 1 - (2 * i + 1.0) / clumps;
    const double girth = std::sqrt(1 - height * height);
    const double turn = i * 2.399963229728653;  // the golden angle
    const glm::dvec3 out(girth * cosine(turn), height, girth * sine(turn));
    const glm::dvec3 pull = glm::dvec3(0.15, -1, 0.1) + random_direction(random) * 0.45;
    const glm::dvec3 across = glm::normalize(glm::cross(out, pull));
    glm::dmat4 place(1.0);
    place[0] = glm::dvec4(glm::cross(across, out), 0);  // where the pull goes along the skin
    place[1] = glm::dvec4(across, 0);
    place[2] = glm::dvec4(out, 0);
    place[3] = glm::dvec4(centre + out, 1);
    places[random.below(kVariants)].push_back(place);
  }
  for (std::uint32_t v = 0; v < kVariants; ++v) {
    const std::string name = "clump " + std::to_string(v);
    scene.draw_instances(scene.add_mesh(name, clump(parameters, random)), name, hair[v % 3], places[v]);
  }
  const CameraPath path({{0, {0.3, 1.75, 3.6}, {0, 1.35, 0}, 45},
                         {4, {1.4, 1.8, 3.3}, {0, 1.35, 0}, 45},
                         {10, {2.9, 1.9, 2.0}, {0, 1.35, 0}, 45}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
