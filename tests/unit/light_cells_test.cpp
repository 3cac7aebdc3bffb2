// The cells of lights against every light's own range, over cameras, points and lights of many sizes.
#include "replay/scene/light_cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <random>
#include <vector>

namespace subpixel::replay {
namespace {

using Light = gpu_types::PointLightConstants;

Light light_at(const glm::vec3& position, float range) {
  return {glm::vec4(position, range), glm::vec4(1, 1, 1, 1.0f / range / range)};
}

// light_cell() of shaders/include/lights.glsl.
std::size_t first_word(const gpu_types::LightCellConstants& cells, const glm::vec3& position) {
  const glm::vec4 point(position, 1);
  const float depth = std::max(glm::dot(cells.rows[2], point), std::numeric_limits<float>::min());
  glm::vec2 tile = glm::vec2(glm::dot(cells.rows[0], point), glm::dot(cells.rows[1], point)) / depth;
  tile = glm::max(glm::min(glm::floor(tile), glm::vec2(cells.tiles)), glm::vec2(0));
  const int key = static_cast<int>(std::bit_cast<std::uint32_t>(depth) >> LIGHT_SLICE_SHIFT);
  const std::uint32_t slice =
      std::min(static_cast<std::uint32_t>(std::max(key - static_cast<int>(cells.slices.x), 0)), cells.slices.y);
  const auto in_slice = static_cast<std::size_t>(tile.y * cells.tiles.z + tile.x);
  return (slice * std::size_t{cells.slices.w} + in_slice) * cells.slices.z;
}

bool finds(const LightCells& cells, std::size_t word, std::size_t light) {
  return (cells.lights.at(word + light / 32) >> light % 32 & 1) != 0;
}

// point_light_attenuation()'s window, in floats as there.
bool reaches(const Light& light, const glm::vec3& position) {
  const glm::vec3 away = glm::vec3(light.position_range) - position;
  const float x = glm::dot(away, away) * light.intensity.w;
  return std::max(1.0f - x * x, 0.0f) > 0;
}

struct Camera {
  const char* name;
  glm::dvec3 eye;
  glm::dmat4 projection;
};

glm::mat4 matrix_of(const Camera& camera) {
  return glm::mat4(camera.projection *
                   glm::lookAt(camera.eye, camera.eye + glm::dvec3(0.3, -0.2, -1), glm::dvec3(0, 1, 0)));
}

std::vector<Camera> cameras() {
  const glm::dmat4 wide = glm::perspective(1.9, 1.7, 0.01, 1000.0), narrow = glm::perspective(0.05, 0.6, 1.0, 50.0);
  return {{"wide", {1, 2, 3}, wide},
          {"far from the origin", {40000, -3000, 90000}, wide},
          {"narrow", {0, 0, 0}, narrow},
          {"endless", {5, 5, 5}, glm::infinitePerspective(1.0, 1.5, 0.1)},
          {"parallel", {-2, 0, 1}, glm::ortho(-8.0, 8.0, -5.0, 5.0, -20.0, 20.0)}};
}

double between(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
glm::dvec3 direction(std::mt19937& random) {
  const glm::dvec3 way(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
  return glm::normalize(way + glm::dvec3(1e-9));
}

std::vector<Light> random_lights(std::mt19937& random, const Camera& camera, std::size_t count) {
  std::vector<Light> lights;
  for (std::size_t i = 0; i < count; ++i) {
    const double distance = std::pow(10.0, between(random, -2, 2.5)), range = std::pow(10.0, between(random, -2, 2));
    lights.push_back(light_at(glm::vec3(camera.eye + direction(random) * distance), static_cast<float>(range)));
  }
  return lights;
}

// Of a light's points those at its border are found last; some lie behind the viewer, beside the screen, before all
// slices or beyond them.
TEST(LightCells, EveryPointFindsAllLightsThatReachIt) {
  std::mt19937 random(11);
  for (const Camera& camera : cameras()) {
    SCOPED_TRACE(camera.name);
    for (const std::size_t count : {1, 31, 33, 300, 1024}) {
      SCOPED_TRACE(count);
      const std::vector<Light> lights = random_lights(random, camera, count);
      const LightCells cells = light_cells(lights, matrix_of(camera));
      ASSERT_LE(cells.lights.size(), kMostLightWords);
      ASSERT_EQ(cells.constants.slices.z, (count + 31) / 32);
      std::size_t reached = 0;
      for (int i = 0; i < 20000; ++i) {
        const Light& near = lights[random() % count];
        const double part = i % 2 == 0 ? between(random, 0.999, 1.0) : std::cbrt(between(random, 0, 1));
        const glm::vec3 point(glm::dvec3(near.position_range) +
                              direction(random) * part * static_cast<double>(near.position_range.w));
        const std::size_t word = first_word(cells.constants, point);
        for (std::size_t l = 0; l < count; l += 1 + count / 64) {
          if (!reaches(lights[l], point)) continue;
          ++reached;
          ASSERT_TRUE(finds(cells, word, l)) << "light " << l << " at " << point.x << ' ' << point.y << ' ' << point.z;
        }
      }
      EXPECT_GT(reached, 200u);
    }
  }
}

// Points at the borders of tiles and slices, which rounding puts on either side.
TEST(LightCells, BordersAreOnTheSafeSide) {
  std::mt19937 random(12);
  for (const Camera& camera : cameras()) {
    SCOPED_TRACE(camera.name);
    const glm::mat4 matrix = matrix_of(camera);
    const glm::dmat4 inverse = glm::inverse(glm::dmat4(matrix));
    for (int i = 0; i < 3000; ++i) {
      const glm::dvec2 border(static_cast<double>(random() % 33) / 16 - 1, static_cast<double>(random() % 17) / 8 - 1);
      const glm::dvec4 at = inverse * glm::dvec4(border, between(random, 0.1, 0.9), 1);
      const glm::vec3 point(glm::dvec3(at) / at.w);
      const double range = std::pow(10.0, between(random, -2, 1));
      // The point is the last one that the light reaches.
      const glm::dvec3 centre = glm::dvec3(point) + direction(random) * (range * 0.9999999);
      const std::vector<Light> lights{light_at(glm::vec3(centre), static_cast<float>(range)),
                                      light_at(glm::vec3(camera.eye), 0.5f)};
      const LightCells cells = light_cells(lights, matrix);
      if (reaches(lights[0], point)) {
        ASSERT_TRUE(finds(cells, first_word(cells.constants, point), 0));
      }
    }
  }
}

TEST(LightCells, LeaveOutMostLightsOfOtherPlaces) {
  std::mt19937 random(13);
  const Camera camera = cameras()[0];
  std::vector<Light> lights;
  for (int i = 0; i < 256; ++i)
    lights.push_back(light_at(glm::vec3(camera.eye + glm::dvec3(between(random, -40, 40), between(random, -20, 20),
                                                                between(random, -80, -2))),
                              2.0f));
  const LightCells cells = light_cells(lights, matrix_of(camera));
  double found = 0;
  constexpr int kPoints = 4000;
  for (int i = 0; i < kPoints; ++i) {
    const glm::vec3 point(camera.eye +
                          glm::dvec3(between(random, -40, 40), between(random, -20, 20), between(random, -80, -2)));
    const std::size_t word = first_word(cells.constants, point);
    for (std::size_t l = 0; l < lights.size(); ++l) found += finds(cells, word, l) ? 1 : 0;
  }
  EXPECT_LT(found / kPoints, 0.05 * 256);
}

TEST(LightCells, OneCellHasAllLightsWhereverAPointLies) {
  const LightCells cells = one_light_cell(70);
  EXPECT_EQ(cells.lights, (std::vector<std::uint32_t>{0xffffffffu, 0xffffffffu, 0x3fu}));
  for (const float place : {-1e20f, -1.0f, 0.0f, 3.0f, 1e20f})
    EXPECT_EQ(first_word(cells.constants, {place, -place, place}), 0u);
  EXPECT_EQ(one_light_cell(0).constants.slices.z, 0u);
}

TEST(LightCells, WithoutLightsThereIsNothingToRead) {
  const LightCells cells = light_cells({}, matrix_of(cameras()[0]));
  EXPECT_EQ(cells.constants.slices.z, 0u);
  EXPECT_EQ(cells.lights, std::vector<std::uint32_t>{0});
}

// The largest and the smallest ranges that a capture may have, and places as far as floats go.
TEST(LightCells, ExtremesStayWithinTheBuffer) {
  std::vector<Light> lights;
  for (const float range : {1e-6f, 1.0f, 1e15f, 1e30f, std::numeric_limits<float>::max()})
    for (const float place : {0.0f, 1e6f, -1e15f, 1e30f}) lights.push_back(light_at({place, -place, place}, range));
  for (const Camera& camera : cameras()) {
    const LightCells cells = light_cells(lights, matrix_of(camera));
    ASSERT_LE(cells.lights.size(), kMostLightWords);
    for (const float place : {0.0f, 1e-30f, 1e7f, -1e7f, 1e15f})
      for (const float depth : {0.0f, 1e7f, -1e15f})
        ASSERT_LT(first_word(cells.constants, {place, -place, depth}), cells.lights.size()) << camera.name;
  }
}

}  // namespace
}  // namespace subpixel::replay
