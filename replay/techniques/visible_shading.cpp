#include "replay/techniques/visible_shading.hpp"

#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/deferred.hpp"

namespace subpixel::replay {

ListedPass visible_shading(const FrameSetup& setup, ShadingPoint point, std::string shader) {
  ListedPass pass;
  pass.name = "shade";
  pass.shader = std::move(shader);
  pass.constants = common_constants(setup);
  pass.constants.emplace_back(SHADE_CONSTANT_POINT, static_cast<std::uint32_t>(point));
  pass.bindings = light_bindings(setup);
  return pass;
}

void record_visible_resolve(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists) {
  gpu::Image& sum = sum_image(recorder, setup);
  gpu::ComputePass pass;
  pass.name = "sum";
  pass.shader = "shade/sum_listed.comp";
  pass.constants = setup.frontend.constants();
  gpu::append(pass.constants, common_constants(setup));
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::image_writes(SHADE_SLOT_SUM_IMAGE, sum)};
  pass.push = gpu::PushConstants(
      gpu_types::VisibleFragmentsPush{.lists = lists.writes(pass), .width = setup.width, .height = setup.height});
  pass.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};
  recorder.compute(std::move(pass));
  record_resolve(recorder, setup, sum);
  if (setup.story != nullptr) setup.story->tell_listed_values(setup, lists);
}

}  // namespace subpixel::replay
