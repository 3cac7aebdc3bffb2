#include "replay/frontend/visibility.hpp"

#include <algorithm>

#include "shaders/frontend/frontend_types.h"

namespace subpixel::replay {

std::uint32_t visibility_group(std::uint32_t samples) {
  return std::min(samples, 16u);
}

gpu::Image& record_visibility(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  const std::uint32_t group = visibility_group(setup.samples);
  const std::uint32_t quads = group / 4;  // 0 for one sample, whose depth and triangle share a texel
  const std::uint32_t layers = group == 1 ? 1 : setup.samples / 2;
  gpu::Image& image = recorder.image(
      {"visibility", VK_FORMAT_R32G32B32A32_UINT, setup.width, setup.height, 1, layers, VK_SAMPLE_COUNT_1_BIT,
       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
  constexpr std::uint32_t kNone = SUBPIXEL_NO_TRIANGLE;
  for (std::uint32_t g = 0; g < setup.samples / group; ++g) {
    Frontend::GeometryPass geometry;
    gpu::RasterPass& pass = geometry.pass;
    pass.name = "visibility";
    const std::string variant = std::to_string(group);
    geometry.fragment_opaque = "frontend/visibility.frag:" + variant;
    geometry.fragment_alpha = "frontend/visibility.frag:" + variant + "A";
    pass.pipeline.constants = common_constants(setup);
    pass.pipeline.constants.emplace_back(4, g);
    pass.pipeline.targets.ordered_read = true;
    pass.pipeline.targets.clear = true;
    if (group == 1) {
      pass.colours = {{image, 0}};
      pass.clear_colours = {{0, kNone, 0, 0}};
    } else {
      for (std::uint32_t layer = 0; layer < 2 * quads; ++layer) {
        pass.colours.emplace_back(image, g * 2 * quads + layer);
        pass.clear_colours.push_back(layer < quads ? std::array<std::uint32_t, 4>{}
                                                   : std::array<std::uint32_t, 4>{kNone, kNone, kNone, kNone});
      }
    }
    pass.pipeline.targets.colours.assign(pass.colours.size(), VK_FORMAT_R32G32B32A32_UINT);
    setup.frontend.record_geometry(recorder, std::move(geometry));
  }
  setup.frontend.record_visible(recorder, image);
  return image;
}

}  // namespace subpixel::replay
