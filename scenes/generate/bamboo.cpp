// A bamboo grove: jointed stalks, thin branches, narrow leaves as geometry. Some different stalks are placed many
// times.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/grass_blades.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scene_parts.hpp"
#include "scenes/generate/scenes.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint32_t kVariants = 5;
constexpr double kJoint_m = 0.34;  // from joint to joint

struct Stalk {
  Mesh cane, leaves;
};

// A narrow leaf, folded a little along its middle and drooping.
void add_leaf(Mesh& mesh, const glm::dvec3& root, const glm::dvec3& along, Random& random) {
  const glm::dvec3 sideways = glm::cross(along, glm::dvec3(0, 1, 0));
  const glm::dvec3 side = glm::normalize(glm::length(sideways) > 1e-6 ? sideways : glm::dvec3(1, 0, 0));
  const double length = random.between(0.12, 0.22);
  const double half_width = length * 0.055;
  const glm::dvec3 droop(0, -0.35 * length, 0);
  const glm::dvec3 normal = glm::normalize(glm::cross(side, along));
  const glm::dvec3 middle = root + along * (0.45 * length) + droop * 0.2;
  const std::uint32_t a = mesh.add_vertex(root, normal, {0.5, 1});
  const std::uint32_t b = mesh.add_vertex(middle - side * half_width + normal * 0.006, normal, {0, 0.5});
  const std::uint32_t c = mesh.add_vertex(middle, normal, {0.5, 0.5});
  const std::uint32_t d = mesh.add_vertex(middle + side * half_width + normal * 0.006, normal, {1, 0.5});
  const std::uint32_t e = mesh.add_vertex(root + along * length + droop, normal, {0.5, 0});
  mesh.add_triangle(a, c, b);
  mesh.add_triangle(a, d, c);
  mesh.add_triangle(b, c, e);
  mesh.add_triangle(c, d, e);
}

Stalk stalk(const BambooParameters& parameters, double density, Random& random) {
  Stalk made;
  const double height = random.between(4.2, 6.5);
  const double lean_turn = random.between(0, 2 * kPi);
  const glm::dvec3 lean = glm::dvec3(cosine(lean_turn), 0, sine(lean_turn)) * random.between(0.02, 0.10);
  const auto middle_line = [&](double h) { return glm::dvec3(0, h, 0) + lean * (h * h / height); };
  const double girth = random.between(0.022, 0.036);
  std::vector<glm::dvec3> path;
  std::vector<double> radii;
  const auto joints = static_cast<std::uint32_t>(height / kJoint_m);
  for (std::uint32_t j = 0; j <= joints; ++j) {
    const double h = j * kJoint_m;
    const double radius = girth * (1 - 0.6 * h / height);
    for (const double step : {-0.012, 0.0, 0.012}) {  // a ring swells at every joint
      path.push_back(middle_line(h + step));
      radii.push_back(radius * (step == 0.0 ? 1.16 : 0.97));
    }
  }
  add_tube(made.cane, path, radii, 9, true);

  const std::uint32_t leaves = scaled_count(parameters.leaves_per_stalk, density);
  constexpr std::uint32_t kBranches = 26;
  for (std::uint32_t b = 0; b < kBranches; ++b) {
    const double h = kJoint_m * (2 + random.below(std::max(joints, 3u) - 2));
    const double turn = random.between(0, 2 * kPi);
    const glm::dvec3 out = glm::normalize(glm::dvec3(cosine(turn), random.between(0.5, 1.2), sine(turn)));
    const double length = random.between(0.35, 0.9);
    const glm::dvec3 root = middle_line(h);
    const glm::dvec3 knee = root + out * (0.6 * length);
    const glm::dvec3 tip = knee + glm::normalize(out + glm::dvec3(0, -0.7, 0)) * (0.4 * length);
    add_tube(made.cane, std::vector{root, knee, tip}, std::vector{0.005, 0.003, 0.0015}, 4, false);
    for (std::uint32_t l = b * leaves / kBranches; l < (b + 1) * leaves / kBranches; ++l) {
      const double t = random.between(0.35, 1.0);
      const glm::dvec3 at = t < 0.6 ? root + (knee - root) * (t / 0.6) : knee + (tip - knee) * ((t - 0.6) / 0.4);
      add_leaf(made.leaves, at, glm::normalize(out * 0.4 + random_direction(random) + glm::dvec3(0, -0.5, 0)), random);
    }
  }
  return made;
}

}  // namespace

Capture bamboo(const GenerateOptions& options, const BambooParameters& parameters) {
  SceneBuilder scene(generated_metadata("bamboo", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{-0.5f, -0.75f, -0.3f}, {4.2f, 4.0f, 3.4f}, true};
  scatter_lights(scene, {-5, 0.4, -12}, {5, 3, 0}, 1.6, 4, random);
  draw_floor(scene, "forest floor", {66, 58, 38}, {112, 100, 66}, 3, 0.95, options.seed + 1);

  const std::uint32_t canes[] = {add_plain_material(scene, "green cane", {0.20, 0.34, 0.08}, 0.4),
                                 add_plain_material(scene, "yellow cane", {0.46, 0.42, 0.14}, 0.42)};
  const std::uint32_t leaf = add_grass_material(scene, "bamboo leaf", {56, 98, 30}, {124, 158, 66});
  std::vector<std::vector<glm::dmat4>> places(kVariants);
  const std::uint32_t stalks = scaled_count(parameters.stalks, options.density);
  for (std::uint32_t i = 0; i < stalks; ++i) {
    const double z = random.between(-16, 0.8);
    const double x = random.between(-1, 1) * (2.6 - 0.45 * z);
    const double turn = random.between(0, 2 * kPi);
    const double size = random.between(0.8, 1.15);
    const std::uint32_t variant = random.below(kVariants);
    if (std::abs(x) < 0.7) continue;  // a way through
    places[variant].push_back(translation({x, 0, z}) * rotation({0, 1, 0}, turn) * scaling({size, size, size}));
  }
  for (std::uint32_t v = 0; v < kVariants; ++v) {
    const Stalk one = stalk(parameters, options.density, random);
    const std::string name = std::to_string(v);
    scene.draw_instances(scene.add_mesh("cane " + name, one.cane), "canes " + name, canes[v % 2], places[v]);
    scene.draw_instances(scene.add_mesh("leaves " + name, one.leaves), "leaves " + name, leaf, places[v]);
  }
  const CameraPath path({{0, {0, 1.6, 2.6}, {0.1, 1.9, -4}, 52},
                         {4, {0.12, 1.6, 1.0}, {0.2, 1.9, -6}, 52},
                         {10, {-0.1, 1.62, -1.6}, {-0.2, 1.9, -9}, 52}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
