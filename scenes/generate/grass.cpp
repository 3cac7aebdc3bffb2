// A field of grass blades on hilly ground, after the grass scene of Kerzner and Salvi, "Streaming G-Buffer Compression
// for Multi-Sample Anti-Aliasing", HPG 2014: many thin curved triangles of about a pixel.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/generate/grass_blades.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_metadata.hpp"
#include "scenes/generate/scenes.hpp"
#include "scenes/generate/textures.hpp"

namespace subpixel::capture {
namespace {

constexpr double kPatchSide_m = 0.5;
constexpr std::uint32_t kVariants = 8;  // different patches
constexpr std::uint32_t kSectors = 6;   // the field is drawn in fans, as an engine culls it
constexpr double kHalfView = 0.76;      // radians to either side of -z that grow grass

// Farther patches are the same blades spread wider: a blade stays about as many pixels wide.
struct Ring {
  double near_m, far_m, scale;
};

double ground_height(double x, double z) {
  const double rolling = 0.22 * sine(0.31 * x + 0.7) * cosine(0.27 * z) + 0.08 * sine(0.9 * x - 0.6 * z);
  const double distance = std::sqrt(x * x + z * z);
  const double rise = std::max(0.0, distance - 22.0);
  return rolling + 0.0007 * rise * rise * (1 + 0.5 * sine(0.11 * x + 2) * cosine(0.07 * z));
}

glm::dvec2 ground_slope(double x, double z) {
  constexpr double kStep = 0.01;
  return glm::dvec2(ground_height(x + kStep, z) - ground_height(x - kStep, z),
                    ground_height(x, z + kStep) - ground_height(x, z - kStep)) /
         (2 * kStep);
}

// A patch follows the slope by shearing, which keeps its blades upright.
glm::dmat4 patch_placement(double x, double z, double scale, Random& random) {
  const glm::dvec2 slope = ground_slope(x, z);
  glm::dmat4 shear(1.0);
  shear[0][1] = slope.x;
  shear[2][1] = slope.y;
  const double tall = random.between(0.85, 1.15) * (1 + 0.25 * (scale - 1));
  return translation({x, ground_height(x, z), z}) * shear * rotation({0, 1, 0}, random.between(0, 2 * kPi)) *
         scaling({scale, tall, scale});
}

void draw_blades(SceneBuilder& scene, const GenerateOptions& options, const GrassParameters& parameters,
                 Random& random) {
  std::array<std::uint32_t, 3> materials{};
  const std::array<std::array<glm::dvec3, 2>, 3> colours{
      {{{{38, 66, 20}, {134, 160, 58}}}, {{{30, 58, 24}, {96, 144, 60}}}, {{{58, 68, 28}, {182, 170, 86}}}}};
  for (std::size_t i = 0; i < materials.size(); ++i) {
    materials[i] = add_grass_material(scene, "grass " + std::to_string(i), colours[i][0], colours[i][1]);
  }
  const double wanted = std::max(1.0, std::floor(parameters.blades_per_patch * options.density + 0.5));
  const auto blades = static_cast<std::uint32_t>(wanted);
  const BladeShape shape{parameters.segments, parameters.blade_height_m, parameters.blade_width_m, kPatchSide_m};
  std::vector<Draw> variants;
  for (std::uint32_t v = 0; v < kVariants; ++v) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < blades; ++i) add_blade(mesh, shape, random);
    variants.push_back(scene.add_mesh("patch " + std::to_string(v), mesh));
  }
  const double far = parameters.view_distance_m;
  for (const Ring& ring : {Ring{0, 0.2 * far, 1}, Ring{0.2 * far, 0.45 * far, 1.6}, Ring{0.45 * far, far, 3}}) {
    std::vector<glm::dmat4> placements[kSectors][kVariants];
    const double side = kPatchSide_m * ring.scale;
    const auto cells = static_cast<int>(ring.far_m / side) + 1;
    for (int row = -cells; row <= 1; ++row) {
      for (int column = -cells; column <= cells; ++column) {
        const double x = (column + random.between(-0.3, 0.3)) * side;
        const double z = (row + random.between(-0.3, 0.3)) * side;
        const double distance = std::sqrt(x * x + z * z);
        const std::uint32_t variant = random.below(kVariants);
        const glm::dmat4 placement = patch_placement(x, z, ring.scale, random);
        // Within a metre of the eye blades would fill the picture.
        if (distance < std::max(ring.near_m, 1.0) || distance >= ring.far_m) continue;
        // The fan opens behind the eye, so that the corners of the picture are covered when the camera moves. Angles
        // are compared by their sines: atan2 differs between machines.
        const double behind = z - 2.0;
        const double lateral = x / std::sqrt(x * x + behind * behind);
        if (z > 0 || std::abs(lateral) > sine(kHalfView)) continue;
        const double place = (lateral / sine(kHalfView) + 1) * 0.5 * kSectors;
        placements[std::min(static_cast<std::uint32_t>(place), kSectors - 1)][variant].push_back(placement);
      }
    }
    for (std::uint32_t s = 0; s < kSectors; ++s) {
      for (std::uint32_t v = 0; v < kVariants; ++v) {
        const std::string name = "grass to " + std::to_string(static_cast<int>(ring.far_m)) + " m, sector " +
                                 std::to_string(s) + ", patch " + std::to_string(v);
        scene.draw_instances(variants[v], name, materials[v % materials.size()], placements[s][v]);
      }
    }
  }
}

void draw_ground(SceneBuilder& scene, const GenerateOptions& options) {
  constexpr std::uint32_t kCells = 96;
  constexpr double kSide_m = 160;
  Mesh mesh;
  for (std::uint32_t row = 0; row <= kCells; ++row) {
    for (std::uint32_t column = 0; column <= kCells; ++column) {
      const double x = (static_cast<double>(column) / kCells - 0.5) * kSide_m;
      const double z = (static_cast<double>(row) / kCells - 0.75) * kSide_m;
      const glm::dvec2 slope = ground_slope(x, z);
      mesh.add_vertex({x, ground_height(x, z), z}, glm::normalize(glm::dvec3(-slope.x, 1, -slope.y)), {x / 3, z / 3});
    }
  }
  for (std::uint32_t row = 0; row < kCells; ++row) {
    for (std::uint32_t column = 0; column < kCells; ++column) {
      const std::uint32_t a = row * (kCells + 1) + column;
      const std::uint32_t below = a + kCells + 1;
      mesh.add_triangle(a, below, below + 1);
      mesh.add_triangle(a, below + 1, a + 1);
    }
  }
  Material material;
  material.name = "ground";
  material.base_colour_texture =
      scene.add_texture(noise_texture("ground", 512, 16, {40, 58, 24}, {84, 104, 44}, options.seed + 11));
  material.roughness = 0.95f;
  scene.draw(scene.add_mesh("ground", mesh), "ground", scene.add_material(material));
}

}  // namespace

Capture grass(const GenerateOptions& options, const GrassParameters& parameters) {
  SceneBuilder scene(generated_metadata("grass", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{-0.45f, -0.62f, -0.64f}, {3.4f, 3.2f, 2.8f}, true};
  for (int i = 0; i < 32; ++i) {
    const double angle = random.between(-0.7, 0.7);
    const double near = random.unit();
    const double distance = 2.5 + 14 * near * random.unit();
    const double x = distance * sine(angle);
    const double z = -distance * cosine(angle);
    const double y = ground_height(x, z) + random.between(0.35, 0.9);
    const double warm = random.unit();
    PointLight light;
    light.position = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    light.intensity = {static_cast<float>(0.5 + 0.4 * warm), 0.5f, static_cast<float>(0.75 - 0.6 * warm)};
    light.range = 3.0f;
    scene.environment.point_lights.push_back(light);
  }
  draw_ground(scene, options);
  draw_blades(scene, options, parameters, random);
  // A slow walk: half a metre in a second moves near blades by a few pixels from frame to frame.
  const auto eye = [](double x, double z) { return glm::dvec3(x, ground_height(x, z) + 1.05, z); };
  const CameraPath path({{0, eye(0, 0.6), eye(0.2, -5) - glm::dvec3(0, 0.65, 0), 46},
                         {3, eye(0.5, -0.4), eye(0.5, -6) - glm::dvec3(0, 0.6, 0), 46},
                         {6, eye(0.3, -1.6), eye(-0.4, -7) - glm::dvec3(0, 0.6, 0), 46},
                         {10, eye(-0.5, -3.0), eye(-1.5, -9) - glm::dvec3(0, 0.6, 0), 46}},
                        0.05);
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
