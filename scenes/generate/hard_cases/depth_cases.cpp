// Hard cases of positions and depths.
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "scenes/generate/hard_cases/case_parts.hpp"
#include "scenes/generate/hard_cases/hard_cases.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/scene_parts.hpp"

namespace subpixel::capture {
namespace {

std::uint32_t add_two_sided(SceneBuilder& scene, const std::string& name, const glm::vec3& colour) {
  Material material;
  material.name = name;
  material.base_colour = {colour.r, colour.g, colour.b, 1};
  material.two_sided = true;
  return scene.add_material(material);
}

}  // namespace

// A floor from behind the eye to far away, and spikes with one or two corners behind it.
Capture hard_near_plane(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_near_plane", options);
  Mesh floor;
  add_quad(floor, {-40, -0.5, 30}, {80, 0, 0}, {0, 0, -90});
  scene.draw(scene.add_mesh("floor", floor), "floor", add_plain_material(scene, "floor", {0.4, 0.5, 0.3}, 0.7));
  Mesh spikes;
  Random random(options.seed);
  for (int i = 0; i < 24; ++i) {
    const bool two_behind = i % 2 == 0;
    const double angle = i * 2 * kPi / 24, reach = random.between(0.3, 0.9);
    const glm::dvec3 out(cosine(angle), sine(angle), 0);
    const glm::dvec3 across(-out.y * 0.06, out.x * 0.06, 0);
    const double behind = random.between(0.2, 5), before = random.between(-6, -1);
    std::array<glm::dvec3, 3> corners{out * reach + across, out * reach - across, out * (0.2 * reach)};
    corners[0].z = corners[1].z = two_behind ? behind : before;
    corners[2].z = two_behind ? before : behind;
    for (const glm::dvec3& corner : corners) spikes.add_vertex(corner, {0, 0, 1}, {0, 0});
    const auto first = static_cast<std::uint32_t>(spikes.positions.size() - 3);
    spikes.add_triangle(first, first + 1, first + 2);
  }
  scene.draw(scene.add_mesh("spikes", spikes), "spikes", add_two_sided(scene, "spikes", {0.8f, 0.3f, 0.1f}));
  const CameraPath path({{0, {0, 0, 0}, {0, -0.05, -1}, 60}, {10, {0.2, 0.1, 0}, {0.2, 0.05, -1}, 60}});
  return scene.finish(path, options.frames, options.width, options.height);
}

// Walls seen from their edges: each reaches from 2 to two million units within a pixel and a half, so its depth changes
// by more in a pixel than a half float can hold.
Capture hard_grazing(const GenerateOptions& options) {
  constexpr double kNear = 2, kFar = 2e6;
  SceneBuilder scene = lit_case("hard_grazing", options);
  const double pixel = pixel_side(1, options);  // at distance 1; grows with the distance
  std::array<Mesh, 2> walls;
  const int count = static_cast<int>(options.width) / 5;
  for (int i = 0; i < count; ++i) {
    const int first_pixel = (i - count / 2) * 5;
    const double from = (first_pixel + 0.37) * pixel, to = from + 1.5 * pixel;
    const double low = -0.3, high = 0.3;
    Mesh& wall = walls[i % 2 == 0 ? 0 : 1];
    const auto first = static_cast<std::uint32_t>(wall.positions.size());
    for (const double distance : {kNear, kFar}) {
      const double x = (distance == kNear ? from : to) * distance;
      wall.add_vertex({x, low * distance, -distance}, {-1, 0, 0}, {0, 0});
      wall.add_vertex({x, high * distance, -distance}, {-1, 0, 0}, {0, 0});
    }
    wall.add_triangle(first, first + 2, first + 3);
    wall.add_triangle(first, first + 3, first + 1);
  }
  const std::array materials{add_two_sided(scene, "light", {0.8f, 0.8f, 0.7f}),
                             add_two_sided(scene, "dark", {0.1f, 0.05f, 0.05f})};
  for (std::size_t i = 0; i < walls.size(); ++i) scene.draw(scene.add_mesh("walls", walls[i]), "walls", materials[i]);
  const CameraPath path({{0, {0, 0, 0}, {0, 0, -1}, 45}, {10, {0.005, 0.005, 0}, {0.005, 0.005, -1}, 45}});
  return scene.finish(path, options.frames, options.width, options.height);
}

// Left: one rectangle drawn twice. Right: two in one plane, cut into triangles differently.
Capture hard_coplanar(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_coplanar", options);
  const std::uint32_t red = add_plain_material(scene, "red", {0.8, 0.1, 0.1}, 0.8);
  const std::uint32_t green = add_plain_material(scene, "green", {0.1, 0.7, 0.1}, 0.8);
  const glm::dvec3 left(-1.7, -1.1, 0.4), right(0.15, -1.1, 0.4), across(1.5, 0.1, 0.3), up(-0.1, 2.1, -0.9);
  Mesh twice, once, cut;
  add_quad(twice, left, across, up);
  add_quad(once, right, across, up);
  // The same plane in three by three parts, which end inside.
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      add_quad(cut, right + across * (0.1 + 0.27 * column) + up * (0.1 + 0.27 * row), across * 0.27, up * 0.27);
  const Draw mesh = scene.add_mesh("twice", twice);
  scene.draw(mesh, "first", red);
  scene.draw(mesh, "second", green);
  scene.draw(scene.add_mesh("once", once), "whole", red);
  scene.draw(scene.add_mesh("cut", cut), "parts", green);
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

// Planes through one axis, and one across.
Capture hard_interpenetrating(const GenerateOptions& options) {
  constexpr int kPlanes = 7;
  SceneBuilder scene = lit_case("hard_interpenetrating", options);
  for (int i = 0; i < kPlanes; ++i) {
    Mesh mesh;
    const double angle = (i + 0.4) * kPi / kPlanes;
    const glm::dvec3 across(1.5 * cosine(angle), 0.2, 1.5 * sine(angle));
    add_quad(mesh, -across - glm::dvec3(0, 1.1, 0), 2.0 * across, {0, 2.2, 0});
    const std::string name = "plane " + std::to_string(i);
    scene.draw(scene.add_mesh(name, mesh), name,
               add_two_sided(scene, name, {0.1f + 0.12f * static_cast<float>(i), i % 2 == 0 ? 0.7f : 0.1f, 0.4f}));
  }
  Mesh across;
  add_quad(across, {-1.4, -0.2, 1.2}, {2.8, 0.3, 0}, {0, 0.5, -2.4});
  scene.draw(scene.add_mesh("across", across), "across", add_two_sided(scene, "across", {0.8f, 0.8f, 0.1f}));
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

// The near plane at 0.01 and the far plane at 100,000; before each of them two sheets lie a thousandth of their
// distance apart, the farther one drawn first and the nearer one a little smaller.
Capture hard_depth_range(const GenerateOptions& options) {
  constexpr double kNear = 0.01, kFar = 1e5;
  SceneBuilder scene = lit_case("hard_depth_range", options);
  const std::uint32_t red = add_plain_material(scene, "behind", {0.8, 0.1, 0.1}, 0.8);
  const std::uint32_t blue = add_plain_material(scene, "before", {0.1, 0.2, 0.8}, 0.8);
  int sheet = 0;
  for (const double distance : {0.02, 1.0, 300.0, 9e4}) {
    const double left = (-0.48 + 0.25 * sheet++) * distance;
    for (const bool behind : {true, false}) {
      const double at = behind ? distance : distance * 0.999, inset = behind ? 0 : 0.03 * distance;
      Mesh mesh;
      add_quad(mesh, {left + inset, -0.3 * distance + inset, -at},
               {0.21 * distance - 2 * inset, 0.01 * distance, -0.1 * distance}, {0, 0.6 * distance - 2 * inset, 0});
      scene.draw(scene.add_mesh("sheet", mesh), behind ? "behind" : "before", behind ? red : blue);
    }
  }
  const CameraPath path({{0, {0, 0, 0}, {0, 0, -1}, 45}, {10, {0.002, 0.001, 0}, {0.002, 0.001, -1}, 45}}, kNear);
  Capture capture = scene.finish(path, options.frames, options.width, options.height);
  for (Frame& frame : capture.frames) {
    frame.projection[10] = static_cast<float>(kNear / (kFar - kNear));
    frame.projection[14] = static_cast<float>(kNear * kFar / (kFar - kNear));
  }
  return capture;
}

// A sphere, and before it triangles of which one, two or all corners are no places, or that have no area.
Capture hard_bad_vertices(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_bad_vertices", options);
  Mesh sphere;
  add_sphere(sphere, {0, 0, 0}, 1, 12);
  scene.draw(scene.add_mesh("sphere", sphere), "sphere", add_plain_material(scene, "grey", {0.6, 0.6, 0.6}, 0.6));
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Mesh bad;
  const std::array<glm::dvec3, 3> corners{glm::dvec3(-1, -1, 1.2), {1, -1, 1.2}, {0, 1, 1.2}};
  const auto add = [&](const std::array<glm::dvec3, 3>& triangle) {
    const auto first = static_cast<std::uint32_t>(bad.positions.size());
    for (const glm::dvec3& corner : triangle) bad.add_vertex(corner, {0, 0, 1}, {0, 0});
    bad.add_triangle(first, first + 1, first + 2);
  };
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), kInfinite, -kInfinite}) {
    for (unsigned which = 1; which < 8; ++which) {
      for (int axis = 0; axis < 3; ++axis) {
        std::array<glm::dvec3, 3> triangle = corners;
        for (unsigned k = 0; k < 3; ++k)
          if ((which >> k & 1) != 0) triangle[k][axis] = value;
        add(triangle);
      }
    }
  }
  add({corners[0], corners[0], corners[0]});
  add({corners[0], corners[1], corners[1]});
  add({corners[0], 0.5 * (corners[0] + corners[1]), corners[1]});
  scene.draw(scene.add_mesh("bad", bad), "bad", add_two_sided(scene, "red", {1, 0, 0}));
  return scene.finish(case_camera(4), options.frames, options.width, options.height);
}

// Placed by transforms, as engines do: the meshes themselves are near their own origins.
Capture hard_far_origin(const GenerateOptions& options) {
  SceneBuilder scene = lit_case("hard_far_origin", options);
  Mesh cube, bars;
  add_box(cube, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
  const double pixel = pixel_side(4, options);
  for (int i = 0; i < 9; ++i) add_strip(bars, {-1.5 + 0.35 * i, -1.2, 0.3}, {-1.3 + 0.35 * i, 1.2, 0.3}, 0.4 * pixel);
  scene.draw(scene.add_mesh("cube", cube), "cube", add_plain_material(scene, "blue", {0.2, 0.35, 0.8}, 0.6),
             translation({kFarOrigin, 0, 0}) * euler_rotation_degrees({31, 37, 0}));
  scene.draw(scene.add_mesh("bars", bars), "bars", add_plain_material(scene, "orange", {0.8, 0.5, 0.2}, 0.6),
             translation({kFarOrigin, 0, 0}));
  scene.environment.point_lights = {{{static_cast<float>(kFarOrigin + 1), 1, 2}, {4, 4, 3}, 8}};
  // An eighth of a unit a frame: a float that large has no smaller step.
  const CameraPath path({{0, {kFarOrigin, 0, 4}, {kFarOrigin, 0, 0}, 45},
                         {10, {kFarOrigin + 37.5, 0, 4}, {kFarOrigin + 37.5, 0, 0}, 45}});
  return scene.finish(path, options.frames, options.width, options.height);
}

}  // namespace subpixel::capture
