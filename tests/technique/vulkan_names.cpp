#include "tests/technique/vulkan_names.hpp"

#include <string_view>

namespace subpixel::tests {

VulkanNames& vulkan_names() {
  static VulkanNames names;
  return names;
}

namespace {

PFN_vkSetDebugUtilsObjectNameEXT real_set_name = nullptr;
PFN_vkCmdBeginDebugUtilsLabelEXT real_begin = nullptr;
PFN_vkCmdEndDebugUtilsLabelEXT real_end = nullptr;

VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice device, const VkDebugUtilsObjectNameInfoEXT* info) {
  vulkan_names().objects.emplace(info->objectType, info->pObjectName);
  return real_set_name(device, info);
}
VKAPI_ATTR void VKAPI_CALL begin(VkCommandBuffer commands, const VkDebugUtilsLabelEXT* label) {
  vulkan_names().labels.push_back(std::string("+").append(label->pLabelName));
  real_begin(commands, label);
}
VKAPI_ATTR void VKAPI_CALL end(VkCommandBuffer commands) {
  vulkan_names().labels.emplace_back("-");
  real_end(commands);
}

template <typename Function>
PFN_vkVoidFunction in_place_of(PFN_vkVoidFunction found, Function& real, Function ours) {
  real = reinterpret_cast<Function>(found);
  return found ? reinterpret_cast<PFN_vkVoidFunction>(ours) : nullptr;
}

}  // namespace
}  // namespace subpixel::tests

// NOLINTBEGIN: the linker's names
extern "C" {
PFN_vkVoidFunction __real_vkGetInstanceProcAddr(VkInstance, const char*);
PFN_vkVoidFunction __wrap_vkGetInstanceProcAddr(VkInstance instance, const char* name) {
  using namespace subpixel::tests;
  const PFN_vkVoidFunction found = __real_vkGetInstanceProcAddr(instance, name);
  const std::string_view wanted = name;
  if (wanted == "vkSetDebugUtilsObjectNameEXT") return in_place_of(found, real_set_name, set_name);
  if (wanted == "vkCmdBeginDebugUtilsLabelEXT") return in_place_of(found, real_begin, begin);
  if (wanted == "vkCmdEndDebugUtilsLabelEXT") return in_place_of(found, real_end, end);
  return found;
}
}
// NOLINTEND
