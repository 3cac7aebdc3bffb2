// Unlit materials show their base colour whatever lights there are, and spot lights light their cone, by every path.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/technique/every_path.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kSide = 32;

// Unlit quarters of several colours whose normals are turned away more and more, under all kinds of light, and around
// them, if so wished, a lit metal frame.
capture::Capture unlit_scene(bool with_lit) {
  auto capture = flat_capture(kSide, kSide);
  auto& frame = capture.frames[0];
  frame.ambient = {1, 2, 3};
  frame.sun = capture::DirectionalLight{{-0.9f, 0, -0.1f}, {9, 9, 9}, true};
  frame.point_lights = {{{0, 0, 0.9f}, {20, 30, 40}, 9}, {{0, 0.5f, 0.5f}, {50, 50, 50}, 9, capture::SpotCone{}}};
  frame.point_lights[1].cone->direction = {0, 0, -1};
  for (std::uint32_t i = 0; i < 4; ++i) {
    capture::Material material;
    material.unlit = true;
    material.base_colour = {std::array{1.0f, 0.02f, 0.5f, 0.0f}[i], 0.25f, std::array{0.1f, 0.7f, 0.5f, 0.0f}[i], 1};
    // None of these counts.
    material.metallic = 0.5f;
    material.roughness = 0.1f * static_cast<float>(i);
    material.emissive = {5, 6, 7};
    capture.materials.push_back(material);
    const float x = i % 2 == 0 ? -1.0f : 0.0f, y = i / 2 == 0 ? -1.0f : 0.0f;
    auto& draw = add_triangles(capture, rectangle(x, y, x + 1, y + 1, 0), i);
    std::vector<float> normals;
    const float turned = 0.5f * static_cast<float>(i);  // radians; the last are seen edge-on
    for (int corner = 0; corner < 6; ++corner) normals.insert(normals.end(), {std::sin(turned), 0, std::cos(turned)});
    draw.normal = {add_buffer(capture, normals), capture::VertexFormat::float32x3, 0, 12};
  }
  if (with_lit) {
    capture::Material metal;
    metal.metallic = 1;
    metal.base_colour = {0.9f, 0.8f, 0.7f, 1};
    metal.roughness = 0.4f;
    capture.materials.push_back(metal);
    add_triangles(capture, rectangle(-1, -0.1f, 1, 0.1f, 0.5f), 4);
  }
  return capture;
}

std::optional<glm::dvec3> unlit_colour(const capture::Capture& capture, bool with_lit, double x, double y) {
  if (x < 0 || y < 0 || x > kSide || y > kSide || std::abs(x - 16) < 0.5) return std::nullopt;
  if (std::abs(y - 16) < (with_lit ? 2.5 : 0.5)) return std::nullopt;
  const auto& colour = capture.materials[(x > 16 ? 1u : 0u) + (y < 16 ? 2u : 0u)].base_colour;
  return glm::dvec3(colour[0], colour[1], colour[2]);
}

TEST(SceneUnlit, ShowsItsBaseColourUnderEveryLight) {
  for (const bool with_lit : {false, true}) {
    const auto capture = unlit_scene(with_lit);
    const auto expected = [&](double x, double y) { return unlit_colour(capture, with_lit, x, y); };
    // A shared exponent has 9 bits for the largest channel.
    for (const PathImage& path : every_path(capture, kSide, kSide)) expect_image(path, kSide, expected, 2e-3, 2e-3);
    for (const ParameterValues& given : std::vector<ParameterValues>{{{"storage", "float"}, {"ndf", "sggx"}},
                                                                     {{"ndf", "sggx"}, {"shading", "blinn_phong"}},
                                                                     {{"samples", 16}, {"roughness", "in_normal"}}})
      expect_image(technique_path(capture, "agaa", kSide, kSide, given), kSide, expected, 2e-3, 0);
    expect_image(technique_path(capture, "hybrid", kSide, kSide, {{"normals", "sggx"}}), kSide, expected, 2e-3, 0);
    for (const char* technique : {"forward", "msaa"})
      expect_image(technique_path(capture, technique, kSide, kSide, {{"shading", "blinn_phong"}}), kSide, expected,
                   2e-3, 0);
    expect_image(reference_path(capture, kSide, kSide, {.samples = 16, .shading_model = 1}), kSide, expected, 0, 2e-3);
  }
}

// What is lit in the scene looks as it does where nothing is unlit.
TEST(SceneUnlit, ChangesNothingOfWhatIsLit) {
  auto with = unlit_scene(true), without = with;
  for (auto& material : without.materials) material.unlit = false;
  const auto a = every_path(with, kSide, kSide), b = every_path(without, kSide, kSide);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (const std::size_t x : {4u, 16u, 27u}) {
      const std::size_t pixel = 16 * kSide + x;
      EXPECT_LT(glm::length(a[i].radiance[pixel] - b[i].radiance[pixel]), 0.01f * glm::length(b[i].radiance[pixel]))
          << a[i].name << " at " << x;
    }
}

TEST(SceneCones, LightTheirInsideAndFadeToTheirEdge) {
  // A lamp above a matte floor, straight down and aslant; where it would light without a cone, times the formula.
  for (const glm::dvec3 direction : {glm::dvec3(0, 0, -1), glm::dvec3(0.8, 0, -1.2)}) {
    auto capture = flat_capture(kSide, kSide);
    capture.frames[0].ambient = {0, 0, 0};
    capture::Material material;
    material.roughness = 1;
    capture.materials.push_back(material);
    add_triangles(capture, {-1, -1, 0, 3, -1, 0, -1, 3, 0}, 0);
    const glm::dvec3 lamp(-0.25, 0.125, 0.75);
    const double inner = 0.93, outer = 0.7;
    capture.frames[0].point_lights = {{{-0.25f, 0.125f, 0.75f}, {2, 3, 4}, 20}};
    const auto everywhere = every_path(capture, kSide, kSide);
    capture.frames[0].point_lights[0].cone =
        capture::SpotCone{{static_cast<float>(direction.x), 0, static_cast<float>(direction.z)}, 0.93f, 0.7f};
    const auto inside = every_path(capture, kSide, kSide);
    for (std::size_t i = 0; i < inside.size(); ++i) {
      std::size_t full = 0, dark = 0, between = 0;
      for (std::uint32_t pixel = 0; pixel < kSide * kSide; ++pixel) {
        const auto factor_at = [&](const glm::dvec2& place) {
          const std::uint32_t column = pixel % kSide, row = pixel / kSide;
          const glm::dvec3 point((column + place.x) / 16 - 1, 1 - (row + place.y) / 16, 0);
          const double cosine = glm::dot(glm::normalize(point - lamp), glm::normalize(direction));
          return std::pow(std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0), 2);
        };
        double factor = factor_at({0.5, 0.5});
        (factor == 0 ? dark : factor == 1 ? full : between) += 1;
        const auto& turns = inside[i].turns;
        if (!turns.empty()) factor = 0;
        for (std::uint32_t sample = 0; sample < 4 * turns.size(); ++sample)
          factor += factor_at(glm::dvec2(sample_place(turns[sample / 4], sample % 4))) /
                    (4.0 * static_cast<double>(turns.size()));
        const double lit = everywhere[i].radiance[pixel].g;
        ASSERT_GT(lit, 0);
        const double found = inside[i].radiance[pixel].g / lit;
        if (inside[i].reference()) {
          // What varies over a pixel besides is left out of the mean.
          ASSERT_NEAR(found, factor, 0.01) << inside[i].name << ", pixel " << pixel;
          continue;
        }
        // Techniques that light samples do so somewhere in the pixel, each where it stores them.
        double lowest = factor, highest = factor;
        const bool centred = inside[i].name.starts_with("noaa") || inside[i].name.starts_with("forward");
        for (int k = 0; k < 25 && !centred; ++k) {
          const int column = k % 5, row = k / 5;
          const double there = factor_at({column / 4.0, row / 4.0});
          lowest = std::min(lowest, there);
          highest = std::max(highest, there);
        }
        ASSERT_GE(found, lowest - 2e-3) << inside[i].name << ", pixel " << pixel;
        ASSERT_LE(found, highest + 2e-3) << inside[i].name << ", pixel " << pixel;
      }
      EXPECT_GT(std::min({full, dark, between}), 20u);
    }
  }
}

}  // namespace
}  // namespace subpixel::replay
