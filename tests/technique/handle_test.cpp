// Vulkan objects have one owner each: whichever call fails while things are made, nothing made before is left.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "base/error.hpp"
#include "replay/gpu/material_sets.hpp"
#include "replay/gpu/pass_recorder.hpp"
#include "shaders/frontend/frontend_interface.h"
#include "tests/technique/vulkan_faults.hpp"

namespace subpixel::replay {
namespace {

using Handles = std::vector<int*>;
Handles& destroyed() {
  static Handles list;
  return list;
}
void destroy(int parent, int* handle, const void*) {
  EXPECT_EQ(parent, 7);
  destroyed().push_back(handle);
}
using Owner = gpu::Unique<int*, destroy, int>;

TEST(UniqueHandle, DestroysOnceWhatItHolds) {
  int a = 0, b = 0;
  destroyed().clear();
  {
    Owner none, one;
    EXPECT_FALSE(one);
    *one.made_by(7) = &a;
    EXPECT_EQ(one.get(), &a);
    Owner moved(std::move(one));
    EXPECT_FALSE(one);  // NOLINT(bugprone-use-after-move): what is left is empty
    EXPECT_EQ(moved.get(), &a);
    none = std::move(moved);
    EXPECT_EQ(none.get(), &a);
    EXPECT_TRUE(destroyed().empty());
    *none.made_by(7) = &b;
    EXPECT_EQ(destroyed(), Handles{&a});
  }
  EXPECT_EQ(destroyed(), (Handles{&a, &b}));
}

// One of everything that holds Vulkan objects, and a run.
void make_everything() {
  gpu::Device device;
  const gpu::Sampler sampler(device, {});
  gpu::Image texture(device, {"texture", VK_FORMAT_R8G8B8A8_UNORM, 4, 4, 2, 3, VK_SAMPLE_COUNT_1_BIT,
                              VK_IMAGE_USAGE_SAMPLED_BIT, false});
  gpu::MaterialSets sets(device, 1);
  sets.set_of({{{&texture, &sampler}, {&texture, &sampler}, {&texture, &sampler}, {&texture, &sampler}}});
  gpu::PassRecorder recorder(device);
  gpu::ComputePass turns;
  turns.name = "turns";
  turns.shader = "frontend/count_turns.comp";
  turns.bindings = {gpu::writes(FRONTEND_SLOT_TURNS, recorder.buffer("turns", 16))};
  recorder.compute(turns);
  gpu::RasterPass raster;
  raster.name = "litmus";
  raster.pipeline.vertex = "frontend/litmus.vert";
  raster.pipeline.fragment = "frontend/litmus.frag:ATTACHMENT";
  raster.pipeline.targets.ordered_read = raster.pipeline.targets.clear = true;
  raster.colours = {
      {recorder.image({"litmus", VK_FORMAT_R32G32B32A32_UINT, 8, 8, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false})}};
  raster.clear_colours = {{}};
  raster.draws = [](gpu::DrawEncoder& encoder) { encoder.draw(3); };
  recorder.raster(raster);
  recorder.run();
}

TEST(VulkanObjects, NoneIsLeftWhicheverCallFails) {
  const auto before = tests::live_vulkan_objects();
  tests::fail_vulkan_call(0);
  make_everything();
  EXPECT_EQ(tests::live_vulkan_objects(), before);
  const std::size_t calls = tests::vulkan_calls();
  EXPECT_GT(calls, 30u);
  for (std::size_t number = 1; number <= calls; ++number) {
    tests::fail_vulkan_call(number);
    EXPECT_THROW(make_everything(), DeviceError) << "call " << number;
    EXPECT_EQ(tests::live_vulkan_objects(), before) << "call " << number;
  }
  tests::fail_vulkan_call(0);
}

TEST(VulkanObjects, NoneIsLeftOfWhatIsTooLarge) {
  gpu::Device device;
  const auto before = tests::live_vulkan_objects();
  const std::uint32_t side = device.info().max_image_dimension + 1;
  EXPECT_THROW(gpu::Image(device, {"wide", VK_FORMAT_R8_UNORM, side, 1}), DeviceError);
  EXPECT_THROW(gpu::Buffer(device, "long", device.info().max_buffer_size + 1), DeviceError);
  EXPECT_EQ(tests::live_vulkan_objects(), before);
}

// Half of an image's views are made when the next one fails.
TEST(VulkanObjects, AnImageOfManyLayersIsWhole) {
  gpu::Device device;
  const auto before = tests::live_vulkan_objects();
  gpu::ImageDescription layers{"layers", VK_FORMAT_R8_UNORM, 1, 1, 1, 8};
  layers.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  tests::fail_vulkan_call(8);  // image, memory, its binding, the whole view, four layers'
  EXPECT_THROW(gpu::Image(device, layers), DeviceError);
  EXPECT_EQ(tests::live_vulkan_objects(), before);
  tests::fail_vulkan_call(0);
  {
    gpu::Image one(device, layers), other;
    EXPECT_EQ(tests::live_vulkan_objects()["ImageView"], 9);
    other = std::move(one);
    EXPECT_FALSE(one);  // NOLINT(bugprone-use-after-move): what is left is empty
    EXPECT_TRUE(other);
  }
  EXPECT_EQ(tests::live_vulkan_objects(), before);
}

}  // namespace
}  // namespace subpixel::replay
