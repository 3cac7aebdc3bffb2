// Lights of cells against all lights for all points: the same bits, whatever lights the frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "replay/reference/reference.hpp"
#include "replay/techniques/registry.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

// Every cell has all of the frame's lights from now on.
void fill_cells(GpuScene& scene) {
  const std::uint32_t count = scene.constants().counts.x, words = scene.constants().light_cells.slices.z;
  ASSERT_GT(words, 0u);
  const auto cells = scene.light_cells.as<std::uint32_t>();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::uint32_t first = static_cast<std::uint32_t>(i % words) * 32, lights = std::min(count - first, 32u);
    cells[i] = lights == 32 ? 0xffffffffu : (1u << lights) - 1;
  }
}

std::uint64_t lights_of_cells(const GpuScene& scene) {
  std::uint64_t sum = 0;
  for (const std::uint32_t word : scene.light_cells.as<std::uint32_t>())
    sum += static_cast<std::uint64_t>(std::popcount(word));
  return sum;
}

class LightCellsOf : public testing::TestWithParam<const Technique*> {};

// Of a city with 45 lights, two words, and of lights with cones.
TEST_P(LightCellsOf, AFrameKeepsTheBitsOfAllLights) {
  for (const bool cones : {false, true}) {
    SCOPED_TRACE(cones);
    capture::Capture capture = capture::generate("city", {.frames = 1, .width = 61, .height = 37, .density = 0.1});
    ASSERT_FALSE(capture.frames[0].point_lights.empty());
    for (auto& light : capture.frames[0].point_lights)
      if (cones) light.cone = capture::SpotCone{{0.2f, -1, 0.1f}, 0.9f, 0.3f};
    FrameScene scene(test_device(), std::move(capture), {.point_lights = 45});
    const FrameRun own = run_frame(scene, GetParam()->with());
    const std::uint64_t before = lights_of_cells(scene.scene);
    fill_cells(scene.scene);
    ASSERT_LT(before, lights_of_cells(scene.scene) / 2);
    const FrameRun all = run_frame(scene, GetParam()->with());
    EXPECT_EQ(own.radiance.pixels, all.radiance.pixels);
    EXPECT_EQ(own.display.pixels, all.display.pixels);
    EXPECT_EQ(own.executions, all.executions);
  }
}

INSTANTIATE_TEST_SUITE_P(Techniques, LightCellsOf,
                         testing::ValuesIn(std::vector<const Technique*>(techniques().begin(), techniques().end())),
                         [](const auto& tested) { return std::string(tested.param->name); });

TEST(LightCellsOf, AReferenceKeepsTheBitsOfAllLights) {
  capture::Capture capture = capture::generate("city", {.frames = 1, .width = 61, .height = 37, .density = 0.1});
  GpuScene scene(test_device(), capture, {.point_lights = 1024});
  scene.set_frame(0, 61, 37);
  const Image own = render_reference(test_device(), scene, {.samples = 16}).linear;
  fill_cells(scene);
  EXPECT_EQ(own.pixels, render_reference(test_device(), scene, {.samples = 16}).linear.pixels);
}

}  // namespace
}  // namespace subpixel::replay
