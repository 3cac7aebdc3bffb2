// Trees of alpha-tested leaf cards: a branching trunk of tubes, and cards with a twig texture around the thin branches.
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scene_parts.hpp"
#include "scenes/generate/scenes.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {
namespace {

constexpr std::uint32_t kVariants = 4;

struct Twig {
  glm::dvec3 at, along;
};

struct Tree {
  Mesh wood, leaves;
};

glm::dvec3 perpendicular(const glm::dvec3& direction, Random& random) {
  const glm::dvec3 other = random_direction(random);
  const glm::dvec3 across = other - direction * glm::dot(other, direction);
  const double length = glm::length(across);
  return length > 1e-3 ? across / length : glm::dvec3(direction.y, -direction.x, 0);
}

// A branch of three bent pieces; its end splits into thinner ones until they are twigs.
void grow(Tree& tree, std::vector<Twig>& twigs, const glm::dvec3& root, const glm::dvec3& direction, double length,
          double radius, std::uint32_t depth, Random& random) {
  std::vector<glm::dvec3> path{root};
  std::vector<double> radii{radius};
  glm::dvec3 along = direction;
  for (int piece = 0; piece < 3; ++piece) {
    along = glm::normalize(along + perpendicular(along, random) * 0.16 + glm::dvec3(0, 0.06, 0));
    path.push_back(path.back() + along * (length / 3));
    radii.push_back(radius * (1 - 0.13 * (piece + 1)));
    if (depth <= 1) twigs.push_back({path.back(), along});
  }
  add_tube(tree.wood, path, radii, depth >= 3 ? 9 : depth == 2 ? 6 : 4, false);
  if (depth == 0) return;
  const std::uint32_t children = 3 + random.below(2);
  for (std::uint32_t i = 0; i < children; ++i) {
    const double spread = random.between(0.55, 0.95);
    const glm::dvec3 out = glm::normalize(along + perpendicular(along, random) * spread);
    grow(tree, twigs, path[i % 2 == 0 ? 3 : 2], out, length * random.between(0.58, 0.75), radii.back() * 0.62,
         depth - 1, random);
  }
}

void add_card(Mesh& mesh, const Twig& twig, Random& random) {
  const double size = random.between(0.22, 0.36);
  const glm::dvec3 up = glm::normalize(twig.along + random_direction(random) * 0.9 + glm::dvec3(0, 0.2, 0));
  const glm::dvec3 right = perpendicular(up, random);
  const glm::dvec3 root = twig.at + random_direction(random) * 0.12;
  add_quad(mesh, root - right * (0.5 * size), right * size, up * size, 1 / size);
}

}  // namespace

Capture foliage(const GenerateOptions& options, const FoliageParameters& parameters) {
  SceneBuilder scene(generated_metadata("foliage", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{-0.48f, -0.68f, -0.45f}, {4.0f, 3.8f, 3.3f}, true};
  scatter_lights(scene, {-9, 0.6, -18}, {9, 3, 2}, 4, 6, random);
  draw_floor(scene, "grass ground", {54, 74, 34}, {96, 116, 56}, 4, 0.95, options.seed + 1);

  const std::uint32_t bark = add_plain_material(scene, "bark", {0.20, 0.15, 0.11}, 0.92);
  std::vector<std::uint32_t> leaves;
  for (const glm::dvec3& colour : {glm::dvec3(84, 132, 48), {112, 146, 52}, {62, 110, 50}, {170, 138, 44}}) {
    const std::string name = "leaf " + std::to_string(leaves.size());
    Material material;
    material.name = name;
    material.base_colour_texture = scene.add_texture(leaf_texture(name, 256, colour, options.seed + leaves.size()));
    material.alpha_mode = AlphaMode::test;
    material.roughness = 0.6f;
    material.two_sided = true;
    leaves.push_back(scene.add_material(material));
  }

  std::vector<std::vector<glm::dmat4>> places(kVariants);
  for (std::uint32_t i = 0; i < parameters.trees; ++i) {
    const std::uint32_t pair = i / 2;
    const double z = 1.0 - 1.5 * pair - random.between(0, 1.5);
    const double side = (i % 2 == 0 ? -1 : 1) * random.between(2.4, 4.5 + 0.22 * i);
    const double size = random.between(0.75, 1.1);
    places[i % kVariants].push_back(translation({side, 0, z}) * rotation({0, 1, 0}, random.between(0, 2 * kPi)) *
                                    scaling({size, size, size}));
  }
  const std::uint32_t cards = scaled_count(parameters.cards_per_tree, options.density);
  for (std::uint32_t v = 0; v < kVariants; ++v) {
    Tree tree;
    std::vector<Twig> twigs;
    grow(tree, twigs, {0, -0.1, 0}, {0, 1, 0}, random.between(2.0, 2.7), 0.17, 4, random);
    for (std::uint32_t c = 0; c < cards; ++c) {
      add_card(tree.leaves, twigs[random.below(static_cast<std::uint32_t>(twigs.size()))], random);
    }
    const std::string name = std::to_string(v);
    scene.draw_instances(scene.add_mesh("wood " + name, tree.wood), "wood " + name, bark, places[v]);
    scene.draw_instances(scene.add_mesh("leaves " + name, tree.leaves), "leaves " + name, leaves[v], places[v]);
  }
  const CameraPath path({{0, {0, 1.7, 6.5}, {0, 2.6, -3}, 52},
                         {4, {0.25, 1.7, 4.6}, {0.1, 2.6, -5}, 52},
                         {10, {-0.2, 1.7, 1.4}, {-0.2, 2.6, -9}, 52}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
