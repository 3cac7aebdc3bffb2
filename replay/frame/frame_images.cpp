#include "replay/frame/frame_images.hpp"

namespace subpixel::replay {
namespace {

constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;

}  // namespace

gpu::Image& target_image(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name, VkFormat format) {
  return recorder.image(
      {std::move(name), format, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT, kTarget, false});
}

gpu::Image& target_array(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name, VkFormat format,
                         std::uint32_t layers) {
  return recorder.image(
      {std::move(name), format, setup.width, setup.height, 1, layers, VK_SAMPLE_COUNT_1_BIT, kTarget, true});
}

std::vector<gpu::Attachment> make_outputs(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.outputs.radiance = &target_image(recorder, setup, "output", VK_FORMAT_R32G32B32A32_SFLOAT);
  setup.outputs.display = &target_image(recorder, setup, "output", VK_FORMAT_R32G32B32A32_SFLOAT);
  return {{*setup.outputs.radiance}, {*setup.outputs.display}};
}

gpu::Image& map_image(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name) {
  return target_image(recorder, setup, std::move(name), VK_FORMAT_R32_UINT);
}

std::vector<gpu::Attachment> make_maps(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                       std::initializer_list<const char*> names) {
  std::vector<gpu::Attachment> maps;
  for (const char* name : names) {
    gpu::Image& map = map_image(recorder, setup, name);
    setup.outputs.maps.emplace_back(name, &map);
    maps.emplace_back(map);
  }
  return maps;
}

gpu::RasterPass fullscreen_pass(const FrameSetup& setup, std::string name, std::string fragment) {
  gpu::RasterPass pass;
  pass.name = std::move(name);
  pass.pipeline.vertex = "shade/fullscreen.vert";
  pass.pipeline.fragment = std::move(fragment);
  pass.pipeline.constants = common_constants(setup);
  for (const auto& constant : setup.frontend.constants()) pass.pipeline.constants.push_back(constant);
  pass.bindings = {gpu::uniform(setup.scene.frame_constants)};
  return pass;
}

std::function<void()> once(std::function<void()> work) {
  return [work = std::move(work), done = false]() mutable {
    if (!done) work();
    done = true;
  };
}

std::function<void()> run_pass(gpu::Device& device, gpu::RasterPass pass) {
  return [&device, pass = std::move(pass)] {
    gpu::PassRecorder own(device);
    own.raster(pass);
    own.run();
  };
}

}  // namespace subpixel::replay
