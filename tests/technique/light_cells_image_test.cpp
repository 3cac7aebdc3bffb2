// Lights of cells against all lights for all points: the same bits, whatever lights the frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "replay/reference/reference.hpp"
#include "replay/techniques/registry.hpp"
#include "tests/technique/technique_run.hpp"

namespace subpixel::replay {
namespace {

constexpr std::uint32_t kWidth = 61, kHeight = 37;

// A city, its own lights with cones or without.
capture::Capture lit_city(bool cones) {
  capture::Capture capture =
      capture::generate("city", {.frames = 1, .width = kWidth, .height = kHeight, .density = 0.1});
  for (auto& light : capture.frames[0].point_lights)
    if (cones) light.cone = capture::SpotCone{{0.2f, -1, 0.1f}, 0.9f, 0.3f};
  return capture;
}

// Lights that a cell has, of all, in the mean.
double lights_of_a_cell(const GpuScene& scene) {
  const gpu_types::LightCellConstants& cells = scene.constants().light_cells;
  const std::size_t count = std::size_t{cells.slices.w} * (cells.slices.y + 1);
  double sum = 0;
  for (const std::uint32_t word : scene.light_cells.as<std::uint32_t>().first(count * cells.slices.z))
    sum += std::popcount(word);
  return sum / static_cast<double>(count);
}

class LightCellsOf : public testing::TestWithParam<const Technique*> {};

// 45 lights: two words of a cell.
TEST_P(LightCellsOf, AFrameKeepsTheBitsOfEveryLight) {
  for (const bool cones : {false, true}) {
    SCOPED_TRACE(cones);
    FrameScene near(test_device(), lit_city(cones), {.point_lights = 45}),
        every(test_device(), lit_city(cones), {.point_lights = 45, .every_light = true});
    ASSERT_EQ(near.scene.features().has(FEATURE_SPOT_LIGHTS), cones);
    ASSERT_EQ(lights_of_a_cell(every.scene), 45);
    ASSERT_LT(lights_of_a_cell(near.scene), 15);
    const FrameRun a = run_frame(near, GetParam()->with()), b = run_frame(every, GetParam()->with());
    EXPECT_EQ(a.radiance.pixels, b.radiance.pixels);
    EXPECT_EQ(a.display.pixels, b.display.pixels);
    EXPECT_EQ(a.executions, b.executions);
  }
}

INSTANTIATE_TEST_SUITE_P(Techniques, LightCellsOf,
                         testing::ValuesIn(std::vector<const Technique*>(techniques().begin(), techniques().end())),
                         [](const auto& tested) { return std::string(tested.param->name); });

TEST(LightCellsOf, AReferenceKeepsTheBitsOfEveryLight) {
  const capture::Capture capture = lit_city(true);
  const auto render = [&](bool every) {
    GpuScene scene(test_device(), capture, {.point_lights = SUBPIXEL_MAX_POINT_LIGHTS, .every_light = every});
    scene.set_frame(0, kWidth, kHeight);
    EXPECT_EQ(lights_of_a_cell(scene) == SUBPIXEL_MAX_POINT_LIGHTS, every);
    return render_reference(test_device(), scene, {.samples = 16}).linear.pixels;
  };
  EXPECT_EQ(render(false), render(true));
}

}  // namespace
}  // namespace subpixel::replay
