// The inside of a small cathedral: a nave under a barrel vault with ribs between two rows of columns and arches,
// aisles, steps up to a choir, an apse. Along -z from the entrance at z = 0; x = 0 is the middle.
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

constexpr double kBay_m = 4.4;
constexpr double kHalfNave_m = 4, kAisle_m = 3.4;  // to the columns' middles; from there to the outer wall
constexpr double kWall_m = 0.7;
constexpr double kColumn_m = 5;                   // height of a column with capital
constexpr double kArcade_m = 8, kVault_m = 11.2;  // where the wall over the arches ends, and where the vault begins
constexpr double kAisleVault_m = 6.8;             // above the arches, whose openings end at 6.75
constexpr double kStep_m = 0.17;
constexpr std::uint32_t kSteps = 6;  // up to the choir

struct Materials {
  std::uint32_t stone, wall, vault, rib, marble, tiles, wood, gold, iron, lamp, glass;
};

Materials add_materials(SceneBuilder& scene, std::uint64_t seed) {
  Materials materials{};
  BrickPattern ashlar{3, 6, 0.5, 0.018, {204, 190, 166}, {188, 172, 146}, {156, 144, 124}};
  materials.wall = add_masonry(scene, "ashlar", ashlar, 0.003, 0.85f, seed);
  BrickPattern vault{4, 12, 0.5, 0.02, {196, 186, 168}, {180, 168, 148}, {158, 148, 130}};
  materials.vault = add_masonry(scene, "vault stones", vault, 0.003, 0.9f, seed + 1);
  BrickPattern tiles{8, 8, 0, 0.012, {196, 186, 170}, {88, 62, 54}, {70, 64, 58}, true};
  materials.tiles = add_masonry(scene, "floor tiles", tiles, 0.0006, 0.22f, seed + 2);
  const auto textured = [&](const std::string& name, std::uint32_t cells, const glm::dvec3& low, const glm::dvec3& high,
                            float roughness, std::uint64_t s) {
    Material material;
    material.name = name;
    material.base_colour_texture = scene.add_texture(noise_texture(name, 256, cells, low, high, s));
    material.roughness = roughness;
    return scene.add_material(material);
  };
  materials.stone = textured("carved stone", 10, {178, 164, 140}, {214, 202, 180}, 0.7f, seed + 3);
  materials.rib = textured("rib stone", 10, {150, 138, 122}, {186, 174, 156}, 0.75f, seed + 4);
  materials.marble = textured("marble", 6, {150, 128, 116}, {216, 204, 192}, 0.25f, seed + 5);
  materials.wood = textured("dark wood", 14, {66, 42, 26}, {98, 64, 40}, 0.4f, seed + 6);
  materials.gold = add_plain_material(scene, "gilding", {0.85, 0.62, 0.25}, 0.3, 1);
  materials.iron = add_plain_material(scene, "iron", {0.10, 0.10, 0.11}, 0.5, 0.9);
  materials.lamp = add_lamp_glass(scene, {0.9f, 0.8f, 0.6f}, {6, 4.4f, 2.4f});
  Material glass;
  glass.name = "stained glass";
  glass.base_colour = {0.02f, 0.02f, 0.02f, 1};
  glass.roughness = 0.2f;
  glass.emissive_texture = scene.add_texture(stained_glass_texture("stained glass", 256, 14, seed + 7));
  glass.emissive = {2.4f, 2.4f, 2.4f};
  materials.glass = scene.add_material(glass);
  return materials;
}

// Plinth, moulded base, shaft with a slight swelling, moulded capital; on the origin.
Mesh column(std::uint32_t sides) {
  Mesh mesh;
  add_box(mesh, {-0.52, 0, -0.52}, {0.52, 0.3, 0.52}, 0.5);
  std::vector<glm::dvec3> path;
  std::vector<double> radii;
  const auto ring = [&](double y, double radius) {
    path.emplace_back(0, y, 0);
    radii.push_back(radius);
  };
  const auto torus = [&](double low, double high, double radius, double swell) {
    for (std::uint32_t i = 0; i <= 6; ++i) {
      const double angle = kPi * i / 6;
      ring(low + (high - low) * (1 - cosine(angle)) / 2, radius + swell * sine(angle));
    }
  };
  torus(0.3, 0.44, 0.44, 0.07);
  torus(0.47, 0.55, 0.40, 0.045);
  for (std::uint32_t i = 0; i <= 6; ++i) ring(0.6 + 3.55 * i / 6, 0.36 + 0.012 * sine(kPi * i / 6) - 0.05 * i / 6);
  torus(4.17, 4.25, 0.31, 0.04);
  for (std::uint32_t i = 0; i <= 6; ++i) ring(4.27 + 0.4 * i / 6, 0.31 + 0.19 * (1 - cosine(kPi / 2 * i / 6)));
  add_tube(mesh, path, radii, sides, false);
  add_box(mesh, {-0.5, 4.67, -0.5}, {0.5, 4.8, 0.5}, 0.5);
  add_box(mesh, {-0.56, 4.8, -0.56}, {0.56, kColumn_m, 0.56}, 0.5);
  return mesh;
}

glm::dvec3 around(double radius, double angle, double springing) {
  return {radius * cosine(angle), springing + radius * sine(angle), 0};
}

// The lower side of a half cylinder along -z: one piece of `length`. uv in metres times `uv_scale`.
Mesh barrel(double radius, double springing, double length, double uv_scale) {
  constexpr std::uint32_t kRound = 32, kAlong = 4;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= kAlong; ++j)
    for (std::uint32_t i = 0; i <= kRound; ++i) {
      const double angle = kPi * i / kRound;
      const glm::dvec3 out = around(1, angle, 0);
      const double z = -length * j / kAlong;
      mesh.add_vertex(around(radius, angle, springing) + glm::dvec3(0, 0, z), -out,
                      glm::dvec2(-z, radius * angle) * uv_scale);
    }
  add_grid_triangles(mesh, kAlong, kRound);
  compute_tangents(mesh);
  return mesh;
}

// A rib under the vault at z = 0, of moulded section, seen from below and from both sides. Flat across, smooth along.
Mesh rib(double radius, double springing, double width, double depth) {
  constexpr std::uint32_t kRound = 32;
  const double half = width / 2;
  // Inwards from the vault and along z.
  const std::vector<glm::dvec2> section{{0, half},
                                        {0.45 * depth, half},
                                        {0.6 * depth, 0.7 * half},
                                        {0.85 * depth, 0.62 * half},
                                        {depth, 0.4 * half},
                                        {depth, -0.4 * half},
                                        {0.85 * depth, -0.62 * half},
                                        {0.6 * depth, -0.7 * half},
                                        {0.45 * depth, -half},
                                        {0, -half}};
  Mesh mesh;
  for (std::size_t k = 0; k + 1 < section.size(); ++k) {
    const glm::dvec2 side = glm::normalize(section[k + 1] - section[k]);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t i = 0; i <= kRound; ++i) {
      const double angle = kPi * i / kRound;
      const glm::dvec3 inward = -around(1, angle, 0);
      const glm::dvec3 normal = inward * -side.y + glm::dvec3(0, 0, side.x);
      for (const glm::dvec2& p : {section[k], section[k + 1]})
        mesh.add_vertex(around(radius - p.x, angle, springing) + glm::dvec3(0, 0, p.y), normal, {radius * angle, p.y});
    }
    for (std::uint32_t i = 0; i < kRound; ++i) {
      const std::uint32_t a = first + 2 * i;
      mesh.add_triangle(a, a + 2, a + 1);
      mesh.add_triangle(a + 1, a + 2, a + 3);
    }
  }
  return mesh;
}

// A moulding along -z on a wall that faces +x at x = 0: steps and a rounded lip, its foot at y = 0.
Mesh moulding(double length) {
  std::vector<glm::dvec2> profile{{0, 0}, {0.05, 0.02}, {0.05, 0.07}};
  for (std::uint32_t i = 0; i <= 8; ++i) {
    const double angle = kPi * i / 8;
    profile.emplace_back(0.09 + 0.08 * sine(angle), 0.15 - 0.08 * cosine(angle));
  }
  profile.insert(profile.end(), {{0.2, 0.25}, {0.26, 0.29}, {0.26, 0.36}, {0, 0.36}});
  Mesh mesh;
  for (std::size_t k = 0; k + 1 < profile.size(); ++k)
    add_quad(mesh, {profile[k].x, profile[k].y, 0}, {0, 0, -length}, glm::dvec3(profile[k + 1] - profile[k], 0));
  return mesh;
}

struct WindowShape {
  double radius, sill, springing;
};
constexpr WindowShape kHighWindow{0.95, 9.0, 9.7};
constexpr WindowShape kAisleWindow{0.75, 2.2, 4.6};

// One bay of wall from `foot` to `top` with a round-headed window, as arched_wall() stands.
Mesh window_wall(const WindowShape& window, double foot, double top) {
  Mesh mesh = arched_wall({kBay_m, window.radius, window.springing, top, kWall_m});
  const double half = kWall_m / 2;
  const double pier = kBay_m / 2 - window.radius;
  add_box(mesh, {-half, foot, -kBay_m}, {half, window.sill, 0});
  add_box(mesh, {-half, window.sill, -pier}, {half, window.springing, 0});
  add_box(mesh, {-half, window.sill, -kBay_m}, {half, window.springing, -kBay_m + pier});
  for (glm::dvec2& uv : mesh.uvs) uv *= 0.45;
  compute_tangents(mesh);
  return mesh;
}

// A rounded frame around the window on the wall's face towards +x.
Mesh window_frame(const WindowShape& window) {
  constexpr std::uint32_t kRound = 20;
  std::vector<glm::dvec3> path;
  const double x = kWall_m / 2;
  const double reach = window.radius + 0.1;
  path.emplace_back(x, window.sill, -kBay_m / 2 + reach);
  for (std::uint32_t i = 0; i <= kRound; ++i) {
    const double angle = kPi * i / kRound;
    path.emplace_back(x, window.springing + reach * sine(angle), -kBay_m / 2 + reach * cosine(angle));
  }
  path.emplace_back(x, window.sill, -kBay_m / 2 - reach);
  Mesh mesh;
  add_tube(mesh, path, std::vector<double>(path.size(), 0.09), 8, false);
  add_box(mesh, {0, window.sill - 0.16, -kBay_m / 2 - reach - 0.15},
          {x + 0.14, window.sill, -kBay_m / 2 + reach + 0.15});
  return mesh;
}

// In the middle of the wall; the corners beside its round head are inside the stone.
Mesh window_glass(const WindowShape& window) {
  const double height = window.springing + window.radius - window.sill;
  Mesh mesh;
  add_quad(mesh, {0, window.sill, -kBay_m / 2 + window.radius}, {0, 0, -2 * window.radius}, {0, height, 0}, 0.5);
  return mesh;
}

// Bars across an open window.
Mesh window_bars(const WindowShape& window) {
  Mesh mesh;
  const double z = -kBay_m / 2;
  const double top = window.springing + window.radius;
  add_bar(mesh, {0, window.sill, z}, {0, top, z}, 0.03, 8, false);
  for (const double y : every(window.sill + 0.4, 0.4, window.springing + 0.5))
    add_bar(mesh, {0, y, z - window.radius}, {0, y, z + window.radius}, 0.02, 6, false);
  return mesh;
}

// Half a round tower seen from inside, centre of its floor at the origin, open towards +z, under half a dome; windows
// are let in as glass on its wall.
Mesh apse_wall(double radius, double springing) {
  constexpr std::uint32_t kRound = 40, kUp = 10;
  Mesh mesh;
  std::vector<glm::dvec2> profile{{radius, 0}, {radius, springing}};
  for (std::uint32_t i = 1; i <= kUp; ++i) {
    const double angle = kPi / 2 * i / kUp;
    profile.emplace_back(radius * cosine(angle), springing + radius * sine(angle));
  }
  double v = 0;
  for (std::size_t k = 0; k < profile.size(); ++k) {
    if (k > 0) v += glm::length(profile[k] - profile[k - 1]);
    const double lift = profile[k].y > springing ? profile[k].y - springing : 0;
    for (std::uint32_t i = 0; i <= kRound; ++i) {
      const double angle = kPi + kPi * i / kRound;
      const glm::dvec3 out(cosine(angle), 0, sine(angle));
      mesh.add_vertex(out * std::max(profile[k].x, 1e-3) + glm::dvec3(0, profile[k].y, 0),
                      -glm::normalize(out * profile[k].x + glm::dvec3(0, lift, 0)),
                      {0.45 * radius * kPi * i / kRound, -0.45 * v});
    }
  }
  add_grid_triangles(mesh, static_cast<std::uint32_t>(profile.size()) - 1, kRound);
  compute_tangents(mesh);
  return mesh;
}

// A moulded baluster of the choir's screen, on the origin.
void add_baluster(Mesh& mesh, const glm::dvec3& foot) {
  std::vector<glm::dvec3> path;
  for (const double y : {0.0, 0.08, 0.16, 0.28, 0.4, 0.55, 0.7, 0.76, 0.84}) path.push_back(foot + glm::dvec3(0, y, 0));
  add_tube(mesh, path, std::vector{0.075, 0.075, 0.05, 0.085, 0.075, 0.045, 0.05, 0.07, 0.07}, 14, false);
}

// Stalls along the choir's sides, an altar behind them with a cross and candles, the screen before them.
void draw_choir(SceneBuilder& scene, const Materials& materials, double front, double back) {
  const double floor = kStep_m * kSteps;
  Mesh screen, stalls, altar, gilded;
  for (const double side : {-1.0, 1.0}) {
    const auto span = [&](Mesh& mesh, double x0, double x1, double y0, double y1, double z0, double z1) {
      add_box(mesh, {std::min(side * x0, side * x1), y0, z0}, {std::max(side * x0, side * x1), y1, z1}, 0.5);
    };
    for (std::uint32_t i = 0; i < 9; ++i) add_baluster(screen, {side * (1.35 + 0.25 * i), floor + 0.1, front - 0.5});
    span(screen, 1.15, 3.6, floor, floor + 0.1, front - 0.65, front - 0.35);
    span(screen, 1.1, 3.6, floor + 0.94, floor + 1.06, front - 0.68, front - 0.32);
    for (const double z : every(back + 1.2, 0.8, front - 1.6)) {
      span(stalls, 2.5, 3.45, floor, floor + 0.5, z - 0.8, z);
      span(stalls, 2.6, 3.4, floor + 0.5, floor + 1.1, z - 0.05, z);
      span(stalls, 3.3, 3.45, floor + 0.5, floor + 2.2, z - 0.76, z - 0.06);
    }
  }
  add_box(altar, {-1.3, floor, back - 1.4}, {1.3, floor + 0.2, back + 0.2}, 0.5);
  add_box(altar, {-1.0, floor + 0.2, back - 1.1}, {1.0, floor + 1.1, back - 0.2}, 0.5);
  add_box(altar, {-1.15, floor + 1.1, back - 1.2}, {1.15, floor + 1.22, back - 0.1}, 0.5);
  add_box(gilded, {-0.05, floor + 1.22, back - 0.9}, {0.05, floor + 2.6, back - 0.8});
  add_box(gilded, {-0.4, floor + 2.05, back - 0.9}, {0.4, floor + 2.15, back - 0.8});
  for (const double x : {-0.9, -0.65, 0.65, 0.9}) {
    const glm::dvec3 foot(x, floor + 1.22, back - 0.6);
    add_tube(gilded, std::vector{foot, foot + glm::dvec3(0, 0.06, 0), foot + glm::dvec3(0, 0.5, 0)},
             std::vector{0.1, 0.03, 0.03}, 10, true);
  }
  scene.draw(scene.add_mesh("choir screen", screen), "choir screen", materials.marble);
  scene.draw(scene.add_mesh("choir stalls", stalls), "choir stalls", materials.wood);
  scene.draw(scene.add_mesh("altar", altar), "altar", materials.marble);
  scene.draw(scene.add_mesh("cross and candles", gilded), "cross and candles", materials.gold);
}

}  // namespace

Capture cathedral(const GenerateOptions& options, const CathedralParameters& parameters) {
  SceneBuilder scene(generated_metadata("cathedral", options));
  scene.environment.sun = DirectionalLight{{-0.60f, -0.74f, -0.30f}, {16.0f, 14.4f, 12.0f}, true};
  scene.environment.ambient = {0.21f, 0.20f, 0.20f};
  const Materials materials = add_materials(scene, options.seed);
  const double length = parameters.bays * kBay_m;
  const double outer = kHalfNave_m + kAisle_m;
  const double end = 3.3 - length;  // of the last bay, where the apse begins
  const double choir = end + 2 * kBay_m;
  constexpr double kAisleRadius_m = (kAisle_m - kWall_m) / 2;

  const auto draw_box = [&](const std::string& name, const glm::dvec3& low, const glm::dvec3& high, double uv_scale,
                            std::uint32_t material) {
    scene.draw(scene.add_mesh(name, boxed(low, high, uv_scale)), name, material);
  };
  draw_box("floor", {-outer, -0.2, end - 4}, {outer, 0, 4}, 0.25, materials.tiles);
  for (std::uint32_t s = 0; s < kSteps; ++s)
    draw_box("step " + std::to_string(s), {-kHalfNave_m + 0.35, 0, end - 4},
             {kHalfNave_m - 0.35, kStep_m * (s + 1), choir - 0.34 * s}, 0.25,
             s + 1 == kSteps ? materials.tiles : materials.marble);
  draw_box("entrance wall", {-outer, 0, 3.3}, {outer, kVault_m + kHalfNave_m + 0.5, 4}, 0.45, materials.wall);

  // What repeats from bay to bay, for the left side (facing +x) and turned for the right.
  std::vector<glm::dmat4> columns, half_columns, arches, strings, high_walls, high_glass, high_bars, aisle_walls,
      vaults, ribs, aisle_vaults, aisle_ribs, lamps;
  for (std::uint32_t b = 0; b <= parameters.bays; ++b) {
    const double z = 3.3 - kBay_m * b;
    const bool last = b == parameters.bays;
    ribs.push_back(translation({0, 0, z}));
    if (!last) vaults.push_back(translation({0, 0, z}));
    for (const double side : {-1.0, 1.0}) {
      const glm::dmat4 turn = side < 0 ? glm::dmat4(1) : rotation({0, 1, 0}, kPi);
      const auto place = [&](double x) { return translation({side * x, 0, side < 0 ? z : z - kBay_m}) * turn; };
      columns.push_back(translation({side * kHalfNave_m, 0, z}));
      half_columns.push_back(translation({side * (kHalfNave_m - kWall_m / 2), 0, z}));
      aisle_ribs.push_back(translation({side * (kHalfNave_m + kAisle_m / 2), 0, z}));
      if (last) continue;
      arches.push_back(place(kHalfNave_m));
      strings.push_back(place(kHalfNave_m - kWall_m / 2) * translation({0, kArcade_m - 0.2, 0}));
      strings.push_back(place(kHalfNave_m - kWall_m / 2) * translation({0, kVault_m - 0.36, 0}));
      strings.push_back(place(outer - kWall_m / 2) * translation({0, kAisleVault_m - 0.36, 0}));
      high_walls.push_back(place(kHalfNave_m));
      (side < 0 ? high_glass : high_bars).push_back(place(kHalfNave_m));
      aisle_walls.push_back(place(outer));
      aisle_vaults.push_back(translation({side * (kHalfNave_m + kAisle_m / 2), 0, z}));
    }
  }
  const auto instances = [&](const std::string& name, const Mesh& mesh, std::uint32_t material,
                             const std::vector<glm::dmat4>& places) {
    scene.draw_instances(scene.add_mesh(name, mesh), name, material, places);
  };
  Mesh arch = arched_wall({kBay_m, kBay_m / 2 - 0.45, kColumn_m, kArcade_m, kWall_m});
  for (glm::dvec2& uv : arch.uvs) uv *= 0.45;
  compute_tangents(arch);
  Mesh half_column;  // from the capitals up to the ribs
  add_bar(half_column, {0, kColumn_m, 0}, {0, kVault_m, 0}, 0.2, 20, false);
  add_tube(half_column,
           std::vector{glm::dvec3(0, kVault_m - 0.5, 0), glm::dvec3(0, kVault_m - 0.2, 0), glm::dvec3(0, kVault_m, 0)},
           std::vector{0.2, 0.3, 0.34}, 20, true);
  instances("columns", column(parameters.column_sides), materials.marble, columns);
  instances("half columns", half_column, materials.stone, half_columns);
  instances("arcade", arch, materials.wall, arches);
  instances("mouldings", moulding(kBay_m), materials.stone, strings);
  instances("high walls", window_wall(kHighWindow, kArcade_m, kVault_m), materials.wall, high_walls);
  instances("high window frames", window_frame(kHighWindow), materials.stone, high_walls);
  instances("high windows", window_glass(kHighWindow), materials.glass, high_glass);
  instances("window bars", window_bars(kHighWindow), materials.iron, high_bars);
  instances("aisle walls", window_wall(kAisleWindow, 0, kArcade_m), materials.wall, aisle_walls);
  instances("aisle window frames", window_frame(kAisleWindow), materials.stone, aisle_walls);
  instances("aisle windows", window_glass(kAisleWindow), materials.glass, aisle_walls);
  instances("vault", barrel(kHalfNave_m - kWall_m / 2, kVault_m, kBay_m, 0.4), materials.vault, vaults);
  instances("ribs", rib(kHalfNave_m - kWall_m / 2, kVault_m, 0.55, 0.28), materials.rib, ribs);
  instances("aisle vaults", barrel(kAisleRadius_m, kAisleVault_m, kBay_m, 0.4), materials.vault, aisle_vaults);
  instances("aisle ribs", rib(kAisleRadius_m, kAisleVault_m, 0.4, 0.2), materials.rib, aisle_ribs);

  const double apse = kHalfNave_m - kWall_m / 2;
  scene.draw(scene.add_mesh("apse", apse_wall(apse, kVault_m)), "apse", materials.wall, translation({0, 0, end}));
  std::vector<glm::dmat4> apse_windows;
  for (const double turn :
       {-0.75, 0.0, 0.75}) {  // a bay's wall turned to face the choir, its glass before the round wall
    apse_windows.push_back(translation({0, 2.2, end}) * rotation({0, 1, 0}, turn - kPi / 2) *
                           translation({-apse + 0.12, 0, kBay_m / 2}));
  }
  instances("apse windows", window_glass(kAisleWindow), materials.glass, apse_windows);
  Mesh apse_frame = window_frame(kAisleWindow);
  for (glm::dvec3& p : apse_frame.positions) p.x -= kWall_m / 2;
  instances("apse window frames", apse_frame, materials.stone, apse_windows);
  for (const double side : {-1.0, 1.0})
    draw_box(side < 0 ? "left aisle end" : "right aisle end", {std::min(side * apse, side * outer), 0, end - 0.5},
             {std::max(side * apse, side * outer), kArcade_m, end}, 0.45, materials.wall);
  draw_choir(scene, materials, choir - 0.34 * (kSteps - 1), end);

  // Lamps on chains in nave and aisles.
  constexpr std::uint32_t kRows = kSceneLights / 4;
  for (std::uint32_t i = 0; i < kSceneLights; ++i) {
    const std::uint32_t row = i / 4;
    const std::array<double, 4> across{-kHalfNave_m - kAisle_m / 2, -1.9, 1.9, kHalfNave_m + kAisle_m / 2};
    const bool aisle = i % 4 == 0 || i % 4 == 3;
    const glm::dvec3 at(across[i % 4], aisle ? 4.4 : 5.6, 3.3 - (length - 0.5) * (row + 0.6) / kRows);
    lamps.push_back(translation(at));
    PointLight light;
    light.position = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
    light.intensity = {7.0f, 5.4f, 3.6f};
    light.range = 11;
    scene.environment.point_lights.push_back(light);
  }
  Mesh globe, chain;
  add_sphere(globe, {0, 0, 0}, 0.13, 8);
  add_bar(chain, {0, 0.1, 0}, {0, 3.2, 0}, 0.012, 6, false);
  add_tube(chain, std::vector{glm::dvec3(0, 0.1, 0), glm::dvec3(0, 0.16, 0), glm::dvec3(0, 0.2, 0)},
           std::vector{0.17, 0.14, 0.03}, 14, false);
  instances("lamp globes", globe, materials.lamp, lamps);
  instances("lamp chains", chain, materials.iron, lamps);

  const CameraPath path({{0, {-1.3, 1.9, 2.4}, {0.5, 4.9, -14}, 62},
                         {4, {-0.9, 1.9, 0.6}, {0.6, 5.0, -16}, 62},
                         {10, {-0.2, 1.95, -3}, {0.6, 5.2, -20}, 62}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
