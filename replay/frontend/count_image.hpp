// What fragments are counted in: additive blending needs floats, which count exactly to 2^24 a pixel.
#pragma once

#include "replay/gpu/resources.hpp"

namespace subpixel::replay {

inline gpu::ImageDescription count_image(std::uint32_t width, std::uint32_t height) {
  return {"fragments",
          VK_FORMAT_R32_SFLOAT,
          width,
          height,
          1,
          1,
          VK_SAMPLE_COUNT_1_BIT,
          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
          false};
}

}  // namespace subpixel::replay
