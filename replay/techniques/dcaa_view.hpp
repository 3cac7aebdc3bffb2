// The camera as decoupled coverage anti-aliasing's planes want it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {

// `view_projection`: world to Vulkan clip space with reversed depth. Perspective and parallel projections.
gpu_types::DcaaView dcaa_view(const glm::mat4& view_projection, std::uint32_t width, std::uint32_t height);

}  // namespace subpixel::replay
