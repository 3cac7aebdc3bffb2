// A street between buildings with much that is thinner than a pixel: window frames, ledges, balcony railings, lamp
// posts, wires, aerials. The street runs along -z, x = 0 in its middle, buildings stand on both sides.
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

constexpr double kFloor_m = 3.2;
constexpr double kGroundFloor_m = 4.0;
constexpr double kDepth_m = 12;  // of a building
constexpr double kStart_m = 14;  // z where the street's first buildings begin
constexpr std::uint32_t kLamps = 32;

struct Materials {
  std::array<std::uint32_t, 3> walls;
  std::uint32_t frame, glass, stone, iron, lamp, asphalt, paving, paint;
};

std::uint32_t add_bricks(SceneBuilder& scene, const std::string& name, const BrickPattern& pattern, float roughness,
                         std::uint64_t seed) {
  Material material;
  material.name = name;
  material.base_colour_texture = scene.add_texture(brick_texture(name, 256, pattern, seed));
  material.normal_texture = scene.add_texture(brick_normal_texture(name + " normals", 256, pattern, 0.008, seed));
  material.roughness = roughness;
  return scene.add_material(material);
}

std::uint32_t add_plain(SceneBuilder& scene, const std::string& name, const std::array<float, 4>& colour,
                        float roughness, float metallic = 0) {
  Material material;
  material.name = name;
  material.base_colour = colour;
  material.roughness = roughness;
  material.metallic = metallic;
  return scene.add_material(material);
}

Materials add_materials(SceneBuilder& scene, std::uint64_t seed) {
  Materials materials{};
  materials.walls[0] = add_bricks(scene, "red brick", {}, 0.9f, seed);
  BrickPattern sandstone{4, 8, 0.5, 0.035, {206, 186, 148}, {184, 160, 122}, {150, 138, 116}};
  materials.walls[1] = add_bricks(scene, "sandstone", sandstone, 0.85f, seed + 1);
  Material plaster;
  plaster.name = "plaster";
  plaster.base_colour_texture =
      scene.add_texture(noise_texture("plaster", 256, 12, {186, 180, 168}, {214, 208, 196}, seed + 2));
  plaster.roughness = 0.95f;
  materials.walls[2] = scene.add_material(plaster);
  materials.frame = add_plain(scene, "window frame", {0.82f, 0.81f, 0.78f, 1}, 0.5f);
  materials.glass = add_plain(scene, "glass", {0.03f, 0.04f, 0.05f, 1}, 0.08f);
  materials.stone = add_plain(scene, "ledge stone", {0.52f, 0.49f, 0.44f, 1}, 0.85f);
  materials.iron = add_plain(scene, "iron", {0.10f, 0.11f, 0.12f, 1}, 0.4f, 0.9f);
  materials.lamp = add_lamp_glass(scene, {0.9f, 0.85f, 0.7f}, {6.0f, 4.8f, 2.8f});
  Material asphalt;
  asphalt.name = "asphalt";
  asphalt.base_colour_texture =
      scene.add_texture(noise_texture("asphalt", 512, 64, {58, 58, 60}, {92, 90, 88}, seed + 3));
  asphalt.roughness = 0.9f;
  materials.asphalt = scene.add_material(asphalt);
  BrickPattern slabs{4, 4, 0.5, 0.03, {150, 148, 142}, {132, 130, 126}, {92, 90, 86}};
  materials.paving = add_bricks(scene, "paving", slabs, 0.8f, seed + 4);
  materials.paint = add_plain(scene, "road paint", {0.75f, 0.75f, 0.72f, 1}, 0.7f);
  return materials;
}

// In a facade's own axes: x to the right along it, y up, z out of the wall; origin at the middle of the lower edge.
Mesh window_frame() {
  Mesh mesh;
  constexpr double kWidth = 1.2;
  constexpr double kHeight = 1.8;
  constexpr double kBar = 0.06;
  add_box(mesh, {-kWidth / 2, 0, 0}, {-kWidth / 2 + kBar, kHeight, 0.08});
  add_box(mesh, {kWidth / 2 - kBar, 0, 0}, {kWidth / 2, kHeight, 0.08});
  add_box(mesh, {-kWidth / 2, kHeight - kBar, 0}, {kWidth / 2, kHeight, 0.08});
  add_box(mesh, {-kWidth / 2, 0, 0}, {kWidth / 2, kBar, 0.08});
  add_box(mesh, {-0.02, 0, 0}, {0.02, kHeight, 0.06});
  for (const double y : {0.62, 1.2}) add_box(mesh, {-kWidth / 2, y - 0.015, 0}, {kWidth / 2, y + 0.015, 0.05});
  add_box(mesh, {-kWidth / 2 - 0.1, -0.08, 0}, {kWidth / 2 + 0.1, 0, 0.2});
  add_box(mesh, {-kWidth / 2 - 0.08, kHeight, 0}, {kWidth / 2 + 0.08, kHeight + 0.16, 0.1});
  return mesh;
}

Mesh window_glass() {
  Mesh mesh;
  add_quad(mesh, {-0.58, 0.02, 0.02}, {1.16, 0, 0}, {0, 1.76, 0});
  return mesh;
}

// Upright bars between two rails along a line on the ground.
void add_railing(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double height, double spacing,
                 double bar_radius) {
  const auto bars = static_cast<std::uint32_t>(std::floor(glm::length(to - from) / spacing + 0.5));
  const glm::dvec3 up(0, height, 0);
  for (std::uint32_t i = 0; i <= bars; ++i) {
    const glm::dvec3 foot = from + (to - from) * (static_cast<double>(i) / bars);
    add_bar(mesh, foot + up * 0.08, foot + up, i == 0 || i == bars ? 1.8 * bar_radius : bar_radius, 6, false);
  }
  add_bar(mesh, from + up, to + up, 2.2 * bar_radius, 8);
  add_bar(mesh, from + up * 0.08, to + up * 0.08, 1.5 * bar_radius, 6);
}

Mesh balcony_railing(double bar_radius) {
  Mesh mesh;
  const glm::dvec3 left(-1.1, 0, 0.9);
  const glm::dvec3 right(1.1, 0, 0.9);
  add_railing(mesh, left, right, 1.0, 0.11, bar_radius);
  add_railing(mesh, {-1.1, 0, 0.05}, left, 1.0, 0.11, bar_radius);
  add_railing(mesh, right, {1.1, 0, 0.05}, 1.0, 0.11, bar_radius);
  return mesh;
}

// At the origin, its arm towards +z.
Mesh lamp_post() {
  Mesh mesh;
  const std::vector<glm::dvec3> path{{0, 0, 0},      {0, 0.9, 0},   {0, 1.0, 0},   {0, 4.6, 0},
                                     {0, 5.1, 0.12}, {0, 5.4, 0.4}, {0, 5.5, 0.8}, {0, 5.5, 1.3}};
  const std::vector<double> radii{0.11, 0.10, 0.06, 0.045, 0.035, 0.03, 0.028, 0.028};
  add_tube(mesh, path, radii, 10, true);
  const std::vector<glm::dvec3> shade{{0, 5.5, 1.3}, {0, 5.42, 1.3}, {0, 5.34, 1.3}};
  add_tube(mesh, shade, std::vector<double>{0.05, 0.16, 0.22}, 12, false);
  return mesh;
}

// A hanging wire; a parabola is as near to a catenary as the eye can tell.
void add_wire(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double sag, double radius) {
  constexpr std::uint32_t kPieces = 20;
  std::vector<glm::dvec3> path;
  for (std::uint32_t i = 0; i <= kPieces; ++i) {
    const double t = static_cast<double>(i) / kPieces;
    path.push_back(from + (to - from) * t - glm::dvec3(0, sag * 4 * t * (1 - t), 0));
  }
  add_tube(mesh, path, std::vector<double>(path.size(), radius), 4, false);
}

struct Parts {
  Draw frame, glass, slab, railing;
};

// One building: `facade` places a facade's axes (see window_frame), `width` is along the street.
void draw_building(SceneBuilder& scene, const Materials& materials, const Parts& parts, const std::string& name,
                   const glm::dmat4& facade, double width, std::uint32_t floors, Random& random) {
  const double height = kGroundFloor_m + floors * kFloor_m;
  const std::uint32_t wall_material = materials.walls[random.below(3)];
  Mesh walls;
  add_box(walls, {-width / 2, 0, -kDepth_m}, {width / 2, height, 0}, 0.5);
  compute_tangents(walls);
  scene.draw(scene.add_mesh(name + " walls", walls), name + " walls", wall_material, facade);

  Mesh ledges;
  add_box(ledges, {-width / 2, 0, 0}, {width / 2, 0.5, 0.06});
  for (std::uint32_t f = 0; f <= floors; ++f) {
    const double y = kGroundFloor_m + f * kFloor_m;
    add_box(ledges, {-width / 2 - 0.02, y - 0.24, 0}, {width / 2 + 0.02, y - 0.10, 0.16});
    add_box(ledges, {-width / 2 - 0.02, y - 0.30, 0}, {width / 2 + 0.02, y - 0.26, 0.08});
  }
  add_box(ledges, {-width / 2 - 0.1, height, -kDepth_m}, {width / 2 + 0.1, height + 0.7, 0.25});
  scene.draw(scene.add_mesh(name + " ledges", ledges), name + " ledges", materials.stone, facade);

  std::vector<glm::dmat4> windows;
  std::vector<glm::dmat4> balconies;
  const auto columns = static_cast<std::uint32_t>(width / 2.6);
  for (std::uint32_t f = 0; f <= floors; ++f) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const double x = (c + 0.5) * width / columns - width / 2;
      const double y = f == 0 ? 1.0 : kGroundFloor_m + (f - 1) * kFloor_m + 0.8;
      windows.push_back(facade * translation({x, y, 0}) * scaling({1, f == 0 ? 1.25 : 1.0, 1}));
      if (f > 0 && f < floors && random.unit() < 0.35) {
        balconies.push_back(facade * translation({x, kGroundFloor_m + (f - 1) * kFloor_m, 0}));
      }
    }
  }
  scene.draw_instances(parts.frame, name + " window frames", materials.frame, windows);
  scene.draw_instances(parts.glass, name + " window panes", materials.glass, windows);
  scene.draw_instances(parts.slab, name + " balconies", materials.stone, balconies);
  scene.draw_instances(parts.railing, name + " balcony railings", materials.iron, balconies);

  Mesh aerials;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 foot{random.between(-0.4, 0.4) * width, height + 0.6, random.between(-5.0, -1.0)};
    const glm::dvec3 top = foot + glm::dvec3(0, random.between(1.5, 3.0), 0);
    add_bar(aerials, foot, top, 0.02, 5);
    for (int k = 1; k <= 4; ++k) {
      const glm::dvec3 middle = top - glm::dvec3(0, 0.18 * k, 0);
      add_bar(aerials, middle - glm::dvec3(0.4, 0, 0), middle + glm::dvec3(0.4, 0, 0), 0.007, 4);
    }
  }
  scene.draw(scene.add_mesh(name + " aerials", aerials), name + " aerials", materials.iron, facade);
}

void draw_street(SceneBuilder& scene, const Materials& materials, const CityParameters& parameters, double end) {
  const double half = parameters.street_width_m / 2;
  const double outer = half + parameters.pavement_width_m;
  constexpr double kBehind_m = 30;
  Mesh road;
  add_quad(road, {-outer, 0, kBehind_m}, {2 * outer, 0, 0}, {0, 0, end - kBehind_m}, 0.25);
  add_quad(road, {-60, -0.02, kBehind_m}, {120, 0, 0}, {0, 0, end - kBehind_m}, 0.25);
  scene.draw(scene.add_mesh("road", road), "road", materials.asphalt);
  Mesh pavement;
  add_box(pavement, {-outer, 0, end}, {-half, 0.14, kBehind_m}, 0.5);
  add_box(pavement, {half, 0, end}, {outer, 0.14, kBehind_m}, 0.5);
  compute_tangents(pavement);
  scene.draw(scene.add_mesh("pavement", pavement), "pavement", materials.paving);
  Mesh dash;
  add_box(dash, {-0.07, 0, -1.5}, {0.07, 0.015, 1.5});
  std::vector<glm::dmat4> dashes;
  for (std::uint32_t i = 0; 10 - 6.0 * i > end; ++i) dashes.push_back(translation({0, 0, 10 - 6.0 * i}));
  scene.draw_instances(scene.add_mesh("dash", dash), "lane marks", materials.paint, dashes);

  Mesh railing;
  add_railing(railing, {0, 0, 0}, {0, 0, -2}, 1.0, 0.12, parameters.railing_bar_radius_m);
  std::vector<glm::dmat4> railings;
  for (std::uint32_t segment = 0; 6 - 2.05 * segment > end + 4; ++segment) {
    if (segment % 9 >= 6) continue;  // gaps to cross the street
    const double z = 6 - 2.05 * segment;
    railings.push_back(translation({-half - 0.25, 0.14, z}));
    railings.push_back(translation({half + 0.25, 0.14, z}));
  }
  scene.draw_instances(scene.add_mesh("street railing", railing), "street railings", materials.iron, railings);
}

void draw_lamps(SceneBuilder& scene, const Materials& materials, const CityParameters& parameters) {
  const double x = parameters.street_width_m / 2 + 0.6;
  Mesh bulb;
  add_sphere(bulb, {0, 5.36, 1.3}, 0.12, 8);
  std::vector<glm::dmat4> posts;
  Mesh wires;
  for (std::uint32_t i = 0; i < kLamps; ++i) {
    const bool left = i % 2 == 0;
    const std::uint32_t pair = i / 2;
    const double z = 4 - 8.0 * pair - (left ? 0 : 4);
    const glm::dvec3 foot(left ? -x : x, 0.14, z);
    posts.push_back(translation(foot) * rotation({0, 1, 0}, left ? kPi / 2 : -kPi / 2));
    const double bulb_x = left ? foot.x + 1.3 : foot.x - 1.3;
    PointLight light;
    light.position = {static_cast<float>(bulb_x), 5.3f, static_cast<float>(z)};
    light.intensity = {22, 17, 10};
    light.range = 14;
    scene.environment.point_lights.push_back(light);
    const glm::dvec3 top = foot + glm::dvec3(0, 5.0, 0);
    add_wire(wires, top, top - glm::dvec3(0, 0, 8), 0.35, parameters.wire_radius_m);
    add_wire(wires, top + glm::dvec3(0, 2.6, 0), {-foot.x, 7.7, z - 4}, 0.5, parameters.wire_radius_m);
  }
  scene.draw_instances(scene.add_mesh("lamp post", lamp_post()), "lamp posts", materials.iron, posts);
  scene.draw_instances(scene.add_mesh("lamp bulb", bulb), "lamp bulbs", materials.lamp, posts);
  scene.draw(scene.add_mesh("wires", wires), "wires", materials.iron);
}

}  // namespace

Capture city(const GenerateOptions& options, const CityParameters& parameters) {
  SceneBuilder scene(generated_metadata("city", options));
  Random random(options.seed);
  scene.environment.sun = DirectionalLight{{0.52f, -0.68f, -0.52f}, {3.2f, 3.0f, 2.6f}, true};
  const Materials materials = add_materials(scene, options.seed);
  Mesh slab;
  add_box(slab, {-1.2, -0.16, 0}, {1.2, 0, 1.0});
  const Parts parts{scene.add_mesh("window frame", window_frame()), scene.add_mesh("window pane", window_glass()),
                    scene.add_mesh("balcony slab", slab),
                    scene.add_mesh("balcony railing", balcony_railing(parameters.railing_bar_radius_m))};

  const double front = parameters.street_width_m / 2 + parameters.pavement_width_m;
  double end = kStart_m;
  for (const bool left : {true, false}) {
    double z = kStart_m;
    for (std::uint32_t b = 0; b < parameters.buildings_per_side; ++b) {
      const double width = random.between(10, 16);
      const glm::dvec3 right = left ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 0, 1);
      glm::dmat4 facade(1.0);
      facade[0] = glm::dvec4(right, 0);
      facade[2] = glm::dvec4(glm::cross(right, glm::dvec3(0, 1, 0)), 0);
      facade[3] = {left ? -front : front, 0, z - width / 2, 1};
      const std::string name = std::string(left ? "left" : "right") + " building " + std::to_string(b);
      draw_building(scene, materials, parts, name, facade, width, 3 + random.below(3), random);
      z -= width + (b % 3 == 2 ? 9.0 : 0.0);  // a side street after every third
    }
    end = std::min(end, z);
  }
  glm::dmat4 facade = translation({0, 0, end - 2});  // closes the street
  draw_building(scene, materials, parts, "end building", facade, 2 * front + 24, 5, random);
  draw_street(scene, materials, parameters, end - 4);
  draw_lamps(scene, materials, parameters);

  const CameraPath path({{0, {-2.6, 1.7, 3}, {-1.2, 2.9, -14}, 52},
                         {4, {-2.3, 1.7, 0.4}, {-0.4, 2.9, -17}, 52},
                         {8, {-1.6, 1.75, -2.4}, {0.9, 2.9, -20}, 52},
                         {12, {-0.6, 1.8, -5.2}, {1.8, 3.0, -23}, 52}},
                        0.1);
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
