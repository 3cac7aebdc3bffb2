// Vulkan's header and the one way a failed call is reported. Only replay/gpu includes this from a source file;
// the other rooms see handles through the classes here.
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

namespace subpixel::gpu {

// Throws DeviceError naming `call` when `result` is an error.
void check(VkResult result, std::string_view call);

}  // namespace subpixel::gpu
