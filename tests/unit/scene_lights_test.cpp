#include "replay/scene/lights.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "replay/scene/frame_points.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::replay {
namespace {

struct Stage {
  capture::Capture capture = capture::generate("spheres", {.frames = 3, .width = 64, .height = 36});
  GeometryPlan plan = plan_geometry(capture, {});
  std::vector<float> positions = std::vector<float>(3 * std::size_t{plan.vertex_count}), normals = positions;
  std::vector<std::uint32_t> indices = std::vector<std::uint32_t>(plan.index_count);
  std::vector<LightStage> stages;
  Bounds bounds;
  Stage() {
    fill_geometry(capture, plan, {positions, normals, {}, {}, indices});
    for (std::uint32_t f = 0; f < 3; ++f) stages.push_back(light_stage(capture, f, plan, positions, indices));
    for (std::uint64_t i = 0; i < stages[0].point_count; ++i) bounds.add(stages[0].point(i));
  }
};

TEST(SceneLights, PlacementIsDeterministicAndAFirstPartOfMore) {
  const Stage a, b;
  const auto few = placed_lights(0, 5, a.stages, a.bounds), many = placed_lights(0, 50, b.stages, b.bounds);
  ASSERT_EQ(few.size(), 5u);
  ASSERT_EQ(many.size(), 50u);
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].position, many[i].position);
    EXPECT_EQ(few[i].intensity, many[i].intensity);
    EXPECT_EQ(few[i].range, many[i].range);
  }
}

TEST(SceneLights, LieInsideTheSceneAndTheView) {
  const Stage stage;
  int in_view = 0;
  const auto lights = placed_lights(0, 32, stage.stages, stage.bounds);
  for (const auto& light : lights) {
    glm::dvec3 position(light.position[0], light.position[1], light.position[2]);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(position[axis], stage.bounds.low[axis] - 1e-5);
      EXPECT_LE(position[axis], stage.bounds.high[axis] + 1e-5);
    }
    EXPECT_GT(light.range, 0);
    EXPECT_LT(light.range, 10);
    for (const float value : light.intensity) EXPECT_GT(value, 0);
    const glm::dvec4 clip = stage.stages[0].camera.view_projection * glm::dvec4(position, 1);
    in_view += std::abs(clip.x) < clip.w && std::abs(clip.y) < clip.w ? 1 : 0;
  }
  EXPECT_GE(in_view, 30);
}

TEST(SceneLights, BrokenLightsAreLeftOutAndTooManyRefused) {
  capture::PointLight good, far, flat;
  far.position[1] = std::numeric_limits<float>::infinity();
  flat.range = 0;
  EXPECT_EQ(light_constants({good, far, flat, good}).size(), 2u);
  capture::Frame frame;
  frame.point_lights.assign(SUBPIXEL_MAX_POINT_LIGHTS, good);
  EXPECT_NO_THROW(require_few_lights(frame, 3));
  EXPECT_EQ(light_constants(frame.point_lights).size(), SUBPIXEL_MAX_POINT_LIGHTS);
  frame.point_lights.push_back(far);
  try {
    require_few_lights(frame, 3);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "frame 3: it has 1025 point lights, at most 1024 can be shaded; a replay that asks for so many takes the "
              "first: "
              "point_lights");
  }
  EXPECT_FLOAT_EQ(light_constants({good})[0].intensity.w, 0.01f);
}

TEST(SceneLights, ConesBelongToTheLightsThatAreKept) {
  capture::PointLight plain, spot, aimless, broken;
  spot.cone = capture::SpotCone{{0, -2, 0}, 0.9f, 0.5f};
  aimless.cone = capture::SpotCone{{0, 0, 0}, 0.9f, 0.5f};
  broken.cone = spot.cone;
  broken.cone->inner_cosine = std::numeric_limits<float>::quiet_NaN();
  const std::vector<capture::PointLight> lights{plain, aimless, spot, broken};
  EXPECT_EQ(light_constants(lights).size(), 2u);
  const auto cones = cone_constants(lights);
  ASSERT_EQ(cones.size(), 2u);
  EXPECT_EQ(cones[0].plane, glm::vec4(0, 0, 0, 1));
  EXPECT_NEAR(cones[1].plane.y, -2.5f, 1e-5);  // unit direction over the cosines between inner and outer
  EXPECT_NEAR(cones[1].plane.w, -1.25f, 1e-5);
  // A cone without an edge is a step, and finite.
  spot.cone->outer_cosine = spot.cone->inner_cosine;
  EXPECT_TRUE(std::isfinite(cone_constants({spot})[0].plane.w));
}

}  // namespace
}  // namespace subpixel::replay
