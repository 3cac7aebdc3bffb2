// The inside of a power plant: a steel frame of several floors with grated walkways, railings and ladders, a furnace
// behind its walls of tubes, tanks, and pipes of all diameters between them. Along -z; x = 0 is the middle.
#include <algorithm>
#include <array>
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

constexpr double kBay_m = 6;  // between the frame's columns, both ways
constexpr double kStorey_m = 4;
constexpr std::uint32_t kStoreys = 4;
constexpr double kHalfWidth_m = 12;
constexpr double kNearEnd_m = 6, kFarEnd_m = -36;  // z
constexpr double kWalkway_m = 3;                   // from the middle to a walkway's
constexpr double kWalkwayWidth_m = 1.2, kPanel_m = 1.5;

// Paints of pipes by what runs in them, as plants mark them.
constexpr std::array<glm::dvec3, 7> kPaints{{{0.10, 0.27, 0.15},
                                             {0.46, 0.47, 0.46},
                                             {0.30, 0.17, 0.09},
                                             {0.12, 0.27, 0.45},
                                             {0.55, 0.10, 0.07},
                                             {0.62, 0.42, 0.10},
                                             {0.66, 0.65, 0.60}}};

struct Materials {
  std::array<std::uint32_t, kPaints.size()> paint;
  std::uint32_t steel, railing, grate, furnace, tank, wheel;
};

Materials add_materials(SceneBuilder& scene, std::uint64_t seed) {
  Materials materials{};
  for (std::size_t i = 0; i < kPaints.size(); ++i)
    materials.paint[i] =
        add_plain_material(scene, "pipe paint " + std::to_string(i), kPaints[i], 0.55 + 0.05 * static_cast<double>(i));
  materials.steel = add_plain_material(scene, "frame paint", {0.24, 0.28, 0.30}, 0.75);
  materials.railing = add_plain_material(scene, "railing paint", {0.70, 0.48, 0.05}, 0.6);
  materials.grate = add_plain_material(scene, "grating", {0.33, 0.33, 0.34}, 0.7, 0.6);
  materials.wheel = add_plain_material(scene, "handwheel paint", {0.50, 0.06, 0.05}, 0.5);
  const auto textured = [&](const std::string& name, const glm::dvec3& low, const glm::dvec3& high, std::uint64_t s) {
    Material material;
    material.name = name;
    material.base_colour_texture = scene.add_texture(noise_texture(name, 256, 8, low, high, s));
    material.roughness = 0.8f;
    return scene.add_material(material);
  };
  materials.furnace = textured("furnace plates", {96, 82, 72}, {138, 124, 112}, seed);
  materials.tank = textured("tank paint", {168, 172, 170}, {204, 204, 198}, seed + 1);
  return materials;
}

// An I section of `height` and flanges of `width` along z from 0 to `length`, its middle at x = y = 0.
Mesh steel_section(double length, double height, double width) {
  constexpr double kFlange_m = 0.025;
  Mesh mesh;
  add_box(mesh, {-width / 2, height / 2 - kFlange_m, 0}, {width / 2, height / 2, length});
  add_box(mesh, {-width / 2, -height / 2, 0}, {width / 2, -height / 2 + kFlange_m, length});
  add_box(mesh, {-0.01, -height / 2 + kFlange_m, 0}, {0.01, height / 2 - kFlange_m, length});
  return mesh;
}

// One panel of a grated floor: bearing bars along z and rods across, its top at y = 0.
Mesh grating() {
  constexpr std::uint32_t kBars = 20, kRods = 6;
  constexpr double kHalf = kWalkwayWidth_m / 2;
  Mesh mesh;
  for (std::uint32_t i = 0; i <= kBars; ++i) {
    const double x = -kHalf + kWalkwayWidth_m * i / kBars;
    add_box(mesh, {x - 0.003, -0.035, 0}, {x + 0.003, 0, kPanel_m});
  }
  for (std::uint32_t i = 0; i < kRods; ++i) {
    const double z = kPanel_m * (i + 0.5) / kRods;
    add_bar(mesh, {-kHalf, -0.006, z}, {kHalf, -0.006, z}, 0.004, 4, false);
  }
  return mesh;
}

// Posts, two rails and a toe board on the side of one panel towards +x.
Mesh railing() {
  constexpr double kEdge = kWalkwayWidth_m / 2;
  Mesh mesh;
  add_bar(mesh, {kEdge, 0, 0}, {kEdge, 1.1, 0}, 0.021, 8, false);
  add_bar(mesh, {kEdge, 1.1, 0}, {kEdge, 1.1, kPanel_m}, 0.021, 8, false);
  add_bar(mesh, {kEdge, 0.55, 0}, {kEdge, 0.55, kPanel_m}, 0.016, 8, false);
  add_box(mesh, {kEdge - 0.003, 0, 0}, {kEdge + 0.003, 0.1, kPanel_m});
  return mesh;
}

// Up one storey from the origin, to be climbed from +z, within a cage of hoops.
Mesh ladder() {
  constexpr double kHalf = 0.22, kCage_m = 0.38;
  constexpr std::uint32_t kHoopSteps = 10;
  Mesh mesh;
  for (const double x : {-kHalf, kHalf}) add_bar(mesh, {x, 0, 0}, {x, kStorey_m + 1, 0}, 0.022, 6);
  for (const double y : every(0.3, 0.3, kStorey_m + 0.9)) add_bar(mesh, {-kHalf, y, 0}, {kHalf, y, 0}, 0.012, 6, false);
  const auto hoop = [&](std::uint32_t step, double y) {
    const double angle = kPi * step / kHoopSteps;
    return glm::dvec3(kCage_m * cosine(angle), y, 2 * kCage_m * sine(angle));
  };
  for (const double y : every(2.2, 0.7, kStorey_m + 1)) {
    std::vector<glm::dvec3> path;
    for (std::uint32_t s = 0; s <= kHoopSteps; ++s) path.push_back(hoop(s, y));
    add_tube(mesh, path, std::vector<double>(path.size(), 0.012), 5, false);
  }
  for (std::uint32_t s = 1; s < kHoopSteps; s += 2)
    add_bar(mesh, hoop(s, 2.2), hoop(s, kStorey_m + 1), 0.009, 5, false);
  return mesh;
}

// An upright round tank of unit size: radius 1, from y = 0 to 1 with shallow heads beyond, seams around it.
Mesh tank_shell(std::uint32_t sides) {
  Mesh mesh;
  std::vector<glm::dvec3> path;
  std::vector<double> radii;
  const auto head = [&](bool top) {
    for (std::uint32_t i = 0; i <= 6; ++i) {
      const double angle = kPi / 2 * (top ? i : 6 - i) / 6.0;
      path.emplace_back(0, (top ? 1.0 : 0.0) + (top ? 0.12 : -0.12) * sine(angle), 0);
      radii.push_back(std::max(0.01, cosine(angle)));
    }
  };
  head(false);
  head(true);
  add_tube(mesh, path, radii, sides, false);
  for (const double y : {0.02, 0.34, 0.66, 0.98})
    add_tube(mesh, std::array{glm::dvec3(0, y - 0.008, 0), glm::dvec3(0, y + 0.008, 0)}, std::array{1.02, 1.02}, sides,
             true);
  return mesh;
}

// Points of a bent pipe: every inner corner of `corners` becomes an arc.
std::vector<glm::dvec3> bent_path(const std::vector<glm::dvec3>& corners, double radius) {
  constexpr std::uint32_t kSteps = 6;
  std::vector<glm::dvec3> path{corners.front()};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const glm::dvec3 in = corners[i] - corners[i - 1];
    const glm::dvec3 out = corners[i + 1] - corners[i];
    const double bend = std::min({3 * radius, 0.45 * glm::length(in), 0.45 * glm::length(out)});
    const glm::dvec3 a = glm::normalize(in) * bend;
    const glm::dvec3 b = glm::normalize(out) * bend;
    for (std::uint32_t s = 0; s <= kSteps; ++s) {  // a quarter of a circle: corners are right angles
      const double angle = kPi / 2 * s / kSteps;
      path.push_back(corners[i] - a * (1 - sine(angle)) + b * (1 - cosine(angle)));
    }
  }
  path.push_back(corners.back());
  return path;
}

void add_flange(Mesh& mesh, const glm::dvec3& at, const glm::dvec3& along, double radius, std::uint32_t sides) {
  for (const double side : {-1.0, 1.0})
    add_bar(mesh, at + along * (side * 0.04 * radius), at + along * (side * 0.36 * radius), 1.6 * radius, sides);
}

// A valve's body goes to `mesh`, its stem and wheel to `wheels`.
void add_valve(Mesh& mesh, Mesh& wheels, const glm::dvec3& at, const glm::dvec3& along, double radius) {
  constexpr std::uint32_t kSteps = 14;
  const glm::dvec3 up = std::abs(along.y) > 0.5 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 across = glm::cross(along, up);
  add_sphere(mesh, at, 1.7 * radius, 6);
  add_flange(mesh, at - along * (2 * radius), along, radius, 12);
  add_flange(mesh, at + along * (2 * radius), along, radius, 12);
  add_bar(mesh, at, at + up * (3.2 * radius), 0.8 * radius, 8);
  const glm::dvec3 hub = at + up * (4.6 * radius);
  add_bar(wheels, at + up * (3 * radius), hub + up * (0.6 * radius), 0.2 * radius, 6);
  const double rim = 1.8 * radius;
  std::vector<glm::dvec3> path;
  for (std::uint32_t s = 0; s <= kSteps; ++s) {
    const double angle = 2 * kPi * (s % kSteps) / kSteps;
    path.push_back(hub + (along * cosine(angle) + across * sine(angle)) * rim);
  }
  add_tube(wheels, path, std::vector<double>(path.size(), 0.17 * radius), 5, false);
  for (const glm::dvec3& spoke : {along, across})
    add_bar(wheels, hub - spoke * rim, hub + spoke * rim, 0.1 * radius, 4, false);
}

// All pipes, by paint.
struct Pipes {
  std::array<Mesh, kPaints.size()> painted;
  Mesh wheels, hangers;
};

void add_pipe(Pipes& pipes, const std::vector<glm::dvec3>& corners, double radius, std::size_t paint, Random& random) {
  Mesh& mesh = pipes.painted[paint];
  const std::uint32_t sides = radius < 0.03 ? 6 : radius < 0.12 ? 10 : 16;
  const auto path = bent_path(corners, radius);
  add_tube(mesh, path, std::vector<double>(path.size(), radius), sides, true);
  if (radius < 0.03) return;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const glm::dvec3 run = corners[i + 1] - corners[i];
    const double length = glm::length(run);
    const glm::dvec3 along = run / length;
    if (length < 14 * radius) continue;
    if (random.unit() < 0.3) add_valve(mesh, pipes.wheels, corners[i] + run * 0.5, along, radius);
    double flange = 5 * radius;
    while (flange < length - 4 * radius) {
      add_flange(mesh, corners[i] + along * flange, along, radius, sides);
      flange += random.between(2.0, 5.0);
    }
    if (std::abs(along.y) > 0.5) continue;
    for (const double at : every(0.8, 3, length))  // hung from the floor above
      add_bar(pipes.hangers, corners[i] + along * at,
              glm::dvec3(0, (std::floor(corners[i].y / kStorey_m) + 1) * kStorey_m - 0.2 - corners[i].y, 0) +
                  corners[i] + along * at,
              0.009, 5, false);
  }
}

// Where people walk there are no pipes.
bool crosses_walkway(const glm::dvec3& a, const glm::dvec3& b, double radius) {
  const glm::dvec3 low = glm::min(a, b) - radius;
  const glm::dvec3 high = glm::max(a, b) + radius;
  for (std::uint32_t storey = 1; storey < kStoreys; ++storey) {
    const double floor = kStorey_m * storey;
    if (high.y < floor - 0.1 || low.y > floor + 2.3) continue;
    for (const double x : {-kWalkway_m, kWalkway_m})
      if (high.x > x - 0.75 && low.x < x + 0.75) return true;
  }
  return false;
}

// A pipe that turns at right angles from a random place.
std::vector<glm::dvec3> wandering_corners(double radius, Random& random) {
  const glm::dvec3 low(-kHalfWidth_m + 0.5, 0.4, kFarEnd_m + 0.5);
  const glm::dvec3 high(kHalfWidth_m - 0.5, kStorey_m * kStoreys - 0.3, kNearEnd_m - 3);
  const double x = random.between(low.x, high.x);
  const double y = random.between(low.y, high.y);
  const double z = random.between(low.z, high.z);
  std::vector<glm::dvec3> corners{{x, y, z}};
  glm::length_t axis = static_cast<glm::length_t>(random.below(3));
  const std::uint32_t runs = 3 + random.below(4);
  for (std::uint32_t tries = 0; corners.size() <= runs && tries < 40; ++tries) {
    const double length = random.between(axis == 1 ? 1.5 : 2.5, axis == 1 ? 6.0 : 11.0);
    glm::dvec3 next = corners.back();
    next[axis] += random.below(2) == 0 ? length : -length;
    if (next[axis] > low[axis] && next[axis] < high[axis] && !crosses_walkway(corners.back(), next, radius)) {
      corners.push_back(next);
      axis = static_cast<glm::length_t>((static_cast<std::uint32_t>(axis) + 1 + random.below(2)) % 3);
    }
  }
  return corners;
}

// Parallel pipes side by side along the building, which rise and come down again together.
void add_rack(Pipes& pipes, double x, double y, std::uint32_t count, double radius, Random& random) {
  const double pitch = 2.0 * radius + std::max(0.02, 0.7 * radius);
  const double loop = random.between(-28.0, -6.0);
  const double drop = random.between(0.3, 0.9);
  const std::size_t paint = random.below(kPaints.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const double at = x + pitch * i;
    const double step = loop - pitch * i;
    add_pipe(pipes, {{at, y, kNearEnd_m - 1}, {at, y, step}, {at, y - drop, step}, {at, y - drop, kFarEnd_m}}, radius,
             (paint + i / 3) % kPaints.size(), random);
  }
}

Pipes all_pipes(const PlantParameters& parameters, double density, Random& random) {
  Pipes pipes;
  for (std::uint32_t i = 0; i < scaled_count(parameters.pipes, density); ++i) {
    const double size = random.unit();
    const double radius = 0.03 + 0.32 * size * size;
    const auto corners = wandering_corners(radius, random);
    if (corners.size() > 1) add_pipe(pipes, corners, radius, random.below(kPaints.size()), random);
  }
  const std::uint32_t racks = scaled_count(parameters.racks, density);
  for (std::uint32_t i = 0; i < racks; ++i) {
    const double storey = kStorey_m * (1 + random.below(kStoreys));
    const double side = random.below(2) == 0 ? -1.0 : 1.0;
    const double x = side < 0 ? random.between(-11.0, -5.5) : random.between(4.2, 8.5);
    const double size = random.unit();
    add_rack(pipes, i % 4 == 0 ? random.between(-1.8, 0.2) : x, storey - random.between(0.4, 0.7), 5 + random.below(8),
             0.015 + 0.10 * size * size, random);
  }
  return pipes;
}

void draw_frame(SceneBuilder& scene, const Materials& materials) {
  std::vector<glm::dmat4> columns, beams;
  const glm::dmat4 upright = rotation({1, 0, 0}, -kPi / 2);
  Mesh braces;
  for (const double z : every(kFarEnd_m, kBay_m, kNearEnd_m))
    for (const double x : every(-kHalfWidth_m, kBay_m, kHalfWidth_m)) {
      columns.push_back(translation({x, 0, z}) * upright);
      for (std::uint32_t storey = 1; storey <= kStoreys; ++storey) {
        const glm::dvec3 joint(x, kStorey_m * storey - 0.25, z);
        if (z > kFarEnd_m) beams.push_back(translation(joint) * rotation({0, 1, 0}, kPi));
        if (x < kHalfWidth_m) beams.push_back(translation(joint) * rotation({0, 1, 0}, kPi / 2));
        const bool outer = x == -kHalfWidth_m || x == kHalfWidth_m;
        if (!outer || z == kFarEnd_m) continue;
        const glm::dvec3 across(0, -kStorey_m, -kBay_m);
        add_bar(braces, joint, joint + across, 0.06, 4);
        add_bar(braces, joint + glm::dvec3(0, 0, -kBay_m), joint + glm::dvec3(0, -kStorey_m, 0), 0.06, 4);
      }
    }
  scene.draw_instances(scene.add_mesh("column", steel_section(kStorey_m * kStoreys + 0.5, 0.32, 0.3)), "columns",
                       materials.steel, columns);
  scene.draw_instances(scene.add_mesh("beam", steel_section(kBay_m, 0.4, 0.18)), "beams", materials.steel, beams);
  scene.draw(scene.add_mesh("braces", braces), "braces", materials.steel);
}

void draw_walkways(SceneBuilder& scene, const Materials& materials) {
  std::vector<glm::dmat4> panels, rails, ladders;
  for (std::uint32_t storey = 1; storey < kStoreys; ++storey) {
    const double y = kStorey_m * storey;
    for (const double x : {-kWalkway_m, kWalkway_m})
      for (std::uint32_t i = 0; kNearEnd_m - kPanel_m * i > kFarEnd_m; ++i) {
        const glm::dmat4 at = translation({x, y, kNearEnd_m - kPanel_m * (i + 1)});
        panels.push_back(at);
        const bool crossing = i % 8 == 6;  // where walkways across begin
        if (!crossing || x > 0) rails.push_back(at);
        if (!crossing || x < 0) rails.push_back(at * translation({0, 0, kPanel_m}) * rotation({0, 1, 0}, kPi));
      }
    for (std::uint32_t c = 0; c < 4; ++c) {
      const double z = kNearEnd_m - kPanel_m * (8 * c + 6.5);
      for (std::uint32_t i = 0; i < 3; ++i) {
        const glm::dmat4 at = translation({-2.25 + kPanel_m * i, y, z}) * rotation({0, 1, 0}, kPi / 2);
        panels.push_back(at);
        rails.push_back(at);
        rails.push_back(at * translation({0, 0, kPanel_m}) * rotation({0, 1, 0}, kPi));
      }
      ladders.push_back(translation({kWalkway_m + 0.9, y - kStorey_m, z - 1.5 - storey}) *
                        rotation({0, 1, 0}, kPi / 2));
      ladders.push_back(translation({-kWalkway_m - 0.9, y - kStorey_m, z - 2 + storey}) *
                        rotation({0, 1, 0}, -kPi / 2));
    }
  }
  scene.draw_instances(scene.add_mesh("grating", grating()), "gratings", materials.grate, panels);
  scene.draw_instances(scene.add_mesh("railing", railing()), "railings", materials.railing, rails);
  scene.draw_instances(scene.add_mesh("ladder", ladder()), "ladders", materials.railing, ladders);
}

// A tall block whose sides are rows of tubes, held by beams around it, with hoppers below and a duct out of its top.
void draw_furnace(SceneBuilder& scene, const Materials& materials) {
  constexpr double kLeft = 4.6, kRight = 11, kFront = -12.5, kBack = -23.5, kFoot = 1.5, kTop = 15;
  constexpr double kTube = 0.035, kPitch = 0.085;
  Mesh plates, tubes, stays;
  add_box(plates, {kLeft, kFoot, kBack}, {kRight, kTop, kFront}, 0.3);
  add_tube(plates, std::vector{glm::dvec3(7.8, 0.3, -15.5), glm::dvec3(7.8, kFoot, -15.5)}, std::vector{0.6, 2.6}, 4,
           false);
  add_tube(plates, std::vector{glm::dvec3(7.8, 0.3, -20.5), glm::dvec3(7.8, kFoot, -20.5)}, std::vector{0.6, 2.6}, 4,
           false);
  add_bar(plates, {7.8, kTop - 1, -18}, {7.8, kTop + 9, -18}, 1.5, 32);
  for (const double z : every(kBack, kPitch, kFront))
    add_bar(tubes, {kLeft, kFoot, z}, {kLeft, kTop, z}, kTube, 8, false);
  for (const double x : every(kLeft, kPitch, kRight))
    add_bar(tubes, {x, kFoot, kFront}, {x, kTop, kFront}, kTube, 8, false);
  for (const double y : every(kFoot + 0.4, 1.9, kTop))
    for (const double edge : {0.0, 0.16}) {
      add_box(stays, {kLeft - 0.28, y + edge, kBack}, {kLeft - 0.04, y + edge + 0.03, kFront + 0.28});
      add_box(stays, {kLeft - 0.04, y + edge, kFront + 0.04}, {kRight, y + edge + 0.03, kFront + 0.28});
    }
  scene.draw(scene.add_mesh("furnace", plates), "furnace", materials.furnace);
  scene.draw(scene.add_mesh("furnace tubes", tubes), "furnace tubes", materials.paint[1]);
  scene.draw(scene.add_mesh("furnace stays", stays), "furnace stays", materials.steel);
}

}  // namespace

Capture plant(const GenerateOptions& options, const PlantParameters& parameters) {
  SceneBuilder scene(generated_metadata("plant", options));
  scene.environment.sun = DirectionalLight{{0.38f, -0.78f, -0.5f}, {4.2f, 4.0f, 3.6f}, true};
  scene.environment.ambient = {0.20f, 0.22f, 0.25f};
  Random random(options.seed);
  const Materials materials = add_materials(scene, options.seed);
  draw_floor(scene, "concrete", {104, 102, 98}, {138, 136, 130}, 9, 0.9, options.seed + 2);
  draw_frame(scene, materials);
  draw_walkways(scene, materials);
  draw_furnace(scene, materials);

  const Draw shell = scene.add_mesh("tank", tank_shell(40));
  std::vector<glm::dmat4> tanks;
  for (const glm::dvec3& foot : {glm::dvec3(-8.8, 0.6, -3), glm::dvec3(-8.8, 0.6, -10), glm::dvec3(-8.4, 4.6, -22)})
    tanks.push_back(translation(foot) * scaling({1.7, 1.7, 1.7}) * scaling({1, 2.6, 1}));
  tanks.push_back(translation({-9.5, 9.4, -5}) * rotation({1, 0, 0}, -kPi / 2) * scaling({1.1, 6.5, 1.1}));
  tanks.push_back(translation({8, 6, 1}) * rotation({1, 0, 0}, -kPi / 2) * scaling({1.2, 7, 1.2}));
  scene.draw_instances(shell, "tanks", materials.tank, tanks);

  const Pipes pipes = all_pipes(parameters, options.density, random);
  for (std::size_t i = 0; i < kPaints.size(); ++i) {
    if (pipes.painted[i].indices.empty()) continue;
    const std::string name = "pipes " + std::to_string(i);
    scene.draw(scene.add_mesh(name, pipes.painted[i]), name, materials.paint[i]);
  }
  if (!pipes.wheels.indices.empty())
    scene.draw(scene.add_mesh("handwheels", pipes.wheels), "handwheels", materials.wheel);
  if (!pipes.hangers.indices.empty()) scene.draw(scene.add_mesh("hangers", pipes.hangers), "hangers", materials.steel);
  scatter_lights(scene, {-10, 2, -34}, {10, 15, 5}, 22, 12, random);

  const CameraPath path({{0, {-3.2, 5.75, 5.2}, {0.9, 6.3, -12}, 58},
                         {4, {-3.1, 5.75, 3.4}, {1.4, 6.5, -14}, 58},
                         {10, {-2.9, 5.8, -1.5}, {2.2, 7.2, -18}, 58}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
