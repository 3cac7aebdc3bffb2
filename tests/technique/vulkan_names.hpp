// The names and labels that reach Vulkan. The linker puts vkGetInstanceProcAddr of this in the loader's place
// (tests/CMakeLists.txt).
#pragma once

#include <vulkan/vulkan.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace subpixel::tests {

struct VulkanNames {
  std::set<std::pair<VkObjectType, std::string>> objects;
  std::vector<std::string> labels;  // "+name" when one begins, "-" when it ends
};
// Since the program's start; to be cleared by who looks at it.
VulkanNames& vulkan_names();

}  // namespace subpixel::tests
