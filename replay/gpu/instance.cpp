#include "replay/gpu/instance.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace subpixel::gpu {
namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

template <typename Function>
void load(VkInstance instance, Function& function, const char* name) {
  function = reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

}  // namespace

bool validation_layer_is_installed() {
  std::uint32_t count = 0;
  check(vkEnumerateInstanceLayerProperties(&count, nullptr), "vkEnumerateInstanceLayerProperties");
  std::vector<VkLayerProperties> layers(count);
  check(vkEnumerateInstanceLayerProperties(&count, layers.data()), "vkEnumerateInstanceLayerProperties");
  return std::ranges::any_of(
      layers, [](const VkLayerProperties& layer) { return std::string_view(layer.layerName) == kLayer; });
}

VkBool32 VKAPI_CALL Instance::hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT,
                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* listener) {
  auto& to = *static_cast<Listener*>(listener);
  const bool error = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  std::string line = error ? "error: " : "warning: ";
  for (const std::string& work : to.work) line += work + ": ";
  to.messages->push_back(line + joined_lines(data->pMessage));
  return VK_FALSE;
}

Instance::Instance(bool names, std::vector<std::string>* messages) {
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "subpixel";
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo create{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  create.pApplicationInfo = &application;
  std::vector<const char*> extensions;
  if (names || messages) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

  constexpr VkValidationFeatureEnableEXT kSynchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  // Given to the instance as well as a messenger of its own: that one speaks before and after the other lives.
  VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = hear;
  VkValidationFeaturesEXT checks{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  checks.enabledValidationFeatureCount = 1;
  checks.pEnabledValidationFeatures = &kSynchronization;
  if (messages) {
    if (!validation_layer_is_installed())
      throw DeviceError("validation", "the Khronos validation layer is not installed (Debian: vulkan-validationlayers)",
                        kLayer);
    listener_ = std::make_unique<Listener>(Listener{messages, {}});
    messenger.pUserData = listener_.get();
    extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    create.pNext = &checks;
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &kLayer;
  }
  create.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  const VkResult result = vkCreateInstance(&create, nullptr, instance_.made_by({}));
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    throw DeviceError("device", "no Vulkan driver is installed (Debian: mesa-vulkan-drivers)", "vkCreateInstance");
  check(result, "vkCreateInstance");
  if (extensions.empty()) return;

  load(get(), set_name_, "vkSetDebugUtilsObjectNameEXT");
  load(get(), begin_label_, "vkCmdBeginDebugUtilsLabelEXT");
  load(get(), end_label_, "vkCmdEndDebugUtilsLabelEXT");
  if (!messages) return;
  messenger.pNext = nullptr;
  PFN_vkCreateDebugUtilsMessengerEXT make = nullptr;
  load(get(), make, "vkCreateDebugUtilsMessengerEXT");
  check(make(get(), &messenger, nullptr, messenger_.made_by(get())), "vkCreateDebugUtilsMessengerEXT");
}

void Instance::destroy_messenger(VkInstance instance, VkDebugUtilsMessengerEXT messenger,
                                 const VkAllocationCallbacks*) {
  PFN_vkDestroyDebugUtilsMessengerEXT destroy = nullptr;
  load(instance, destroy, "vkDestroyDebugUtilsMessengerEXT");
  destroy(instance, messenger, nullptr);
}

void Instance::name_object(VkDevice device, VkObjectType type, std::uint64_t handle, const std::string& name) const {
  VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = handle;
  info.pObjectName = name.c_str();
  check(set_name_(device, &info), "vkSetDebugUtilsObjectNameEXT");
}

void Instance::begin_label(VkCommandBuffer commands, const std::string& name) const {
  if (!begin_label_) return;
  VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
  label.pLabelName = name.c_str();
  begin_label_(commands, &label);
}

void Instance::end_label(VkCommandBuffer commands) const {
  if (end_label_) end_label_(commands);
}

Instance::Work::Work(Instance& instance, std::string_view kind, std::string_view name)
    : stack_(instance.listener_ ? &instance.listener_->work : nullptr) {
  if (stack_) stack_->push_back(fmt::format("{} '{}'", kind, name));
}

Instance::Work::~Work() {
  if (stack_) stack_->pop_back();
}

}  // namespace subpixel::gpu
