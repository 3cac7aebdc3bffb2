// Names of objects and labels around passes reach Vulkan when they are asked for, and only then.
#include <gtest/gtest.h>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/frontend/frontend_interface.h"
#include "tests/technique/vulkan_names.hpp"

namespace subpixel::replay {
namespace {

// Two passes, of which the second draws to an image of two layers.
void run_passes(gpu::Device& device) {
  gpu::PassRecorder recorder(device);
  gpu::ComputePass turns;
  turns.name = "make turns";
  turns.shader = "frontend/count_turns.comp";
  turns.bindings = {gpu::writes(FRONTEND_SLOT_TURNS, recorder.buffer("turn counts", 16))};
  recorder.compute(turns);
  gpu::RasterPass raster;
  raster.name = "draw in order";
  raster.pipeline.vertex = "frontend/litmus.vert";
  raster.pipeline.fragment = "frontend/litmus.frag:ATTACHMENT";
  raster.pipeline.targets.ordered_read = raster.pipeline.targets.clear = true;
  raster.colours = {{recorder.image({"states", VK_FORMAT_R32G32B32A32_UINT, 8, 8, 1, 2, VK_SAMPLE_COUNT_1_BIT,
                                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false}),
                     1}};
  raster.clear_colours = {{}};
  raster.draws = [](gpu::DrawEncoder& encoder) { encoder.draw(3); };
  recorder.raster(raster);
  recorder.run();
  recorder.run();
}

TEST(Names, ReachVulkanWhenAskedFor) {
  auto& names = tests::vulkan_names();
  names = {};
  gpu::DeviceOptions options;
  options.names = true;
  gpu::Device device(options);
  run_passes(device);
  using Labels = std::vector<std::string>;
  EXPECT_EQ(names.labels,
            (Labels{"+make turns", "-", "+draw in order", "-", "+make turns", "-", "+draw in order", "-"}));
  const std::vector<std::pair<VkObjectType, std::string>> expected{
      {VK_OBJECT_TYPE_BUFFER, "turn counts"},
      {VK_OBJECT_TYPE_IMAGE, "states"},
      {VK_OBJECT_TYPE_IMAGE_VIEW, "states"},
      {VK_OBJECT_TYPE_IMAGE_VIEW, "states layer 1"},
      {VK_OBJECT_TYPE_FRAMEBUFFER, "draw in order"},
      {VK_OBJECT_TYPE_SHADER_MODULE, "frontend/litmus.vert"},
      {VK_OBJECT_TYPE_PIPELINE, "frontend/count_turns.comp"},
      {VK_OBJECT_TYPE_PIPELINE, "frontend/litmus.vert + frontend/litmus.frag:ATTACHMENT"},
  };
  for (const auto& [type, name] : expected) EXPECT_TRUE(names.objects.contains({type, name})) << type << " " << name;
}

TEST(Names, StayHereWhenNot) {
  auto& names = tests::vulkan_names();
  names = {};
  gpu::Device device;
  run_passes(device);
  EXPECT_TRUE(names.objects.empty());
  EXPECT_TRUE(names.labels.empty());
}

}  // namespace
}  // namespace subpixel::replay
