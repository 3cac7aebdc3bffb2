// A hall between two rows of columns and arches, with a gallery above them, open to the sky. It runs along -z; x = 0 is
// its middle.
#include <array>
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

constexpr double kBay_m = 4;
constexpr double kColumn_m = 3.1;  // height of a column with capital: where the arch begins
constexpr double kArchRadius_m = 1.65;
constexpr double kWall_m = 0.5;    // thickness
constexpr double kFloor_m = 5.4;   // height of the gallery's floor
constexpr double kHalfHall_m = 4;  // from the middle to the columns
constexpr double kAisle_m = 3;     // from the columns to the outer wall

struct Materials {
  std::uint32_t brick, stone, marble, floor, iron, lamp;
};

Materials add_materials(SceneBuilder& scene, std::uint64_t seed) {
  Materials materials{};
  BrickPattern bricks{8, 16, 0.5, 0.07, {164, 104, 78}, {138, 82, 62}, {176, 168, 152}};
  materials.brick = add_masonry(scene, "brick", bricks, 0.005, 0.9f, seed);
  BrickPattern blocks{3, 6, 0.5, 0.02, {206, 192, 164}, {190, 174, 146}, {150, 140, 120}};
  materials.stone = add_masonry(scene, "stone", blocks, 0.004, 0.8f, seed + 1);
  BrickPattern tiles{4, 4, 0, 0.02, {188, 176, 156}, {120, 92, 74}, {90, 84, 76}};
  materials.floor = add_masonry(scene, "tiles", tiles, 0.002, 0.35f, seed + 2);
  Material marble;
  marble.name = "marble";
  marble.base_colour_texture =
      scene.add_texture(noise_texture("marble", 256, 6, {176, 172, 166}, {224, 220, 212}, seed + 3));
  marble.roughness = 0.3f;
  materials.marble = scene.add_material(marble);
  materials.iron = add_plain_material(scene, "iron", {0.12, 0.12, 0.13}, 0.4, 0.9);
  materials.lamp = add_lamp_glass(scene, {0.9f, 0.8f, 0.6f}, {7, 5, 2.6f});
  return materials;
}

// Base, tapering shaft and capital, standing on the origin.
Mesh column(std::uint32_t sides) {
  Mesh mesh;
  add_box(mesh, {-0.34, 0, -0.34}, {0.34, 0.18, 0.34});
  const std::vector<glm::dvec3> path{{0, 0.18, 0}, {0, 0.26, 0}, {0, 0.34, 0}, {0, 0.4, 0},  {0, 1.5, 0},
                                     {0, 2.6, 0},  {0, 2.66, 0}, {0, 2.7, 0},  {0, 2.86, 0}, {0, 2.95, 0}};
  const std::vector<double> radii{0.30, 0.31, 0.27, 0.23, 0.225, 0.2, 0.23, 0.21, 0.29, 0.31};
  add_tube(mesh, path, radii, sides, false);
  add_box(mesh, {-0.34, 2.95, -0.34}, {0.34, kColumn_m, 0.34});
  return mesh;
}

// Balusters and a rail over one bay, at the gallery's edge.
Mesh balustrade() {
  constexpr std::uint32_t kBalusters = 16;
  Mesh mesh;
  for (std::uint32_t i = 0; i < kBalusters; ++i) {
    const double z = -kBay_m * (i + 0.5) / kBalusters;
    const std::vector<glm::dvec3> path{{0, 0.08, z}, {0, 0.2, z}, {0, 0.34, z}, {0, 0.6, z}, {0, 0.86, z}};
    add_tube(mesh, path, std::vector{0.03, 0.052, 0.04, 0.022, 0.034}, 10, false);
  }
  add_box(mesh, {-0.08, 0, -kBay_m}, {0.08, 0.08, 0});
  add_box(mesh, {-0.09, 0.86, -kBay_m}, {0.09, 0.96, 0});
  return mesh;
}

// A lamp 1.5 m below the origin, on a chain of links.
Mesh lamp_iron() {
  Mesh mesh;
  constexpr std::uint32_t kLinks = 22;
  for (std::uint32_t i = 0; i < kLinks; ++i) {
    const double top = -1.3 * i / kLinks;
    const glm::dvec3 across = i % 2 == 0 ? glm::dvec3(0.018, 0, 0) : glm::dvec3(0, 0, 0.018);
    const glm::dvec3 low(0, top - 0.075, 0);
    const glm::dvec3 high(0, top, 0);
    add_tube(mesh,
             std::vector{low, low + across + glm::dvec3(0, 0.02, 0), high + across - glm::dvec3(0, 0.02, 0), high,
                         high - across - glm::dvec3(0, 0.02, 0), low - across + glm::dvec3(0, 0.02, 0), low},
             std::vector<double>(7, 0.004), 4, false);
  }
  for (std::uint32_t i = 0; i < 8; ++i) {  // a cage around the glass
    const double angle = 2 * kPi * i / 8;
    const glm::dvec3 out(cosine(angle), 0, sine(angle));
    add_tube(mesh,
             std::vector{glm::dvec3(0, -1.3, 0), glm::dvec3(0, -1.36, 0) + out * 0.12,
                         glm::dvec3(0, -1.56, 0) + out * 0.14, glm::dvec3(0, -1.68, 0) + out * 0.03},
             std::vector<double>(4, 0.006), 5, false);
  }
  return mesh;
}

}  // namespace

Capture arcade(const GenerateOptions& options, const ArcadeParameters& parameters) {
  SceneBuilder scene(generated_metadata("arcade", options));
  scene.environment.sun = DirectionalLight{{0.42f, -0.84f, -0.34f}, {5.0f, 4.7f, 4.1f}, true};
  scene.environment.ambient = {0.16f, 0.17f, 0.2f};
  const Materials materials = add_materials(scene, options.seed);
  const double length = parameters.bays * kBay_m;
  const double outer = kHalfHall_m + kAisle_m;

  std::vector<glm::dmat4> columns;
  std::vector<glm::dmat4> arches;
  std::vector<glm::dmat4> edges;
  std::vector<glm::dmat4> lamps;
  for (std::uint32_t b = 0; b <= parameters.bays; ++b) {
    const double z = -kBay_m * b;
    for (const double side : {-1.0, 1.0}) {
      columns.push_back(translation({side * kHalfHall_m, 0, z}));
      if (b == parameters.bays) continue;
      arches.push_back(translation({side * kHalfHall_m, 0, z}));
      edges.push_back(translation({side * (kHalfHall_m - 0.1), kFloor_m + 0.25, z}));
    }
  }
  // Two rows of lamps under the arches, and along the hall what is left of the 32.
  constexpr std::uint32_t kLampRows = kSceneLights / 4;
  for (std::uint32_t i = 0; i < kSceneLights; ++i) {
    const std::uint32_t row = i / 4;
    const double z = -length * (row + 0.5) / kLampRows;
    const std::array<double, 4> across{-outer + 1.4, -1.4, 1.4, outer - 1.4};
    const double x = across[i % 4];
    lamps.push_back(translation({x, kFloor_m - 0.2 + (i % 4 == 1 || i % 4 == 2 ? 0.8 : 0.0), z}));
    PointLight light;
    light.position = {static_cast<float>(x), static_cast<float>(lamps.back()[3].y - 1.5), static_cast<float>(z)};
    light.intensity = {6.5f, 4.9f, 2.9f};
    light.range = 7;
    scene.environment.point_lights.push_back(light);
  }
  scene.draw(scene.add_mesh("floor", boxed({-outer, -0.2, -length - 4}, {outer, 0, 6}, 0.5)), "floor", materials.floor);
  for (const double side : {-1.0, 1.0}) {
    const std::string name = side < 0 ? "left" : "right";
    const double near_x = side * outer;
    const double far_x = side * (outer + 0.6);
    scene.draw(scene.add_mesh(name + " wall", boxed({std::min(near_x, far_x), 0, -length - 4},
                                                    {std::max(near_x, far_x), 10.5, 6}, 0.4)),
               name + " wall", materials.brick);
    const double edge = side * (kHalfHall_m - 0.25);
    scene.draw(scene.add_mesh(name + " gallery", boxed({std::min(edge, near_x), kFloor_m, -length},
                                                       {std::max(edge, near_x), kFloor_m + 0.25, 0}, 0.4)),
               name + " gallery", materials.stone);
  }
  scene.draw(scene.add_mesh("end wall", boxed({-outer, 0, -length - 4}, {outer, 10.5, -length - 3.4}, 0.4)), "end wall",
             materials.brick);
  scene.draw_instances(scene.add_mesh("column", column(parameters.column_sides)), "columns", materials.marble, columns);
  Mesh arch = arched_wall({kBay_m, kArchRadius_m, kColumn_m, kFloor_m, kWall_m});
  for (glm::dvec2& uv : arch.uvs) uv *= 0.6;
  compute_tangents(arch);
  scene.draw_instances(scene.add_mesh("arch", arch), "arches", materials.stone, arches);
  scene.draw_instances(scene.add_mesh("balustrade", balustrade()), "balustrades", materials.marble, edges);
  scene.draw_instances(scene.add_mesh("lamp iron", lamp_iron()), "lamp irons", materials.iron, lamps);
  Mesh glass;
  add_sphere(glass, {0, -1.5, 0}, 0.1, 10);
  scene.draw_instances(scene.add_mesh("lamp glass", glass), "lamp glasses", materials.lamp, lamps);
  // The hall's own lamps hang from wires across it.
  Mesh wires;
  for (std::uint32_t row = 0; row < kLampRows; ++row) {
    const double z = -length * (row + 0.5) / kLampRows;
    add_bar(wires, {-kHalfHall_m, kFloor_m + 0.6, z}, {kHalfHall_m, kFloor_m + 0.6, z}, 0.008, 5);
  }
  scene.draw(scene.add_mesh("wires", wires), "wires", materials.iron);

  const CameraPath path({{0, {-1.6, 1.7, 3.2}, {0.2, 2.7, -9}, 54},
                         {4, {-1.2, 1.7, 1.2}, {0.5, 2.7, -11}, 54},
                         {10, {-0.2, 1.75, -2.4}, {0.8, 2.7, -14}, 54}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
