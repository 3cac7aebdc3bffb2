// The Vulkan instance, and what lets one see inside the device: the Khronos validation layer and names.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "replay/gpu/handle.hpp"

namespace subpixel::gpu {

// Whether the loader finds VK_LAYER_KHRONOS_validation.
bool validation_layer_is_installed();

class Instance {
 public:
  // With `messages`, the validation layer with its checks of synchronization says what it finds there, until the
  // instance has ended: "error: WORK: …" or "warning: WORK: …", one line each. `names`, and `messages`, turn names on.
  // Throws DeviceError without Vulkan, and when messages are wanted and the layer is not installed.
  Instance(bool names, std::vector<std::string>* messages);

  VkInstance get() const { return instance_.get(); }

  // Whether the validation layer's messages are taken.
  bool listens() const { return listener_ && listener_->messages; }

  // Names an object of `device` for messages, RenderDoc and other layers. Nothing happens unless names are on.
  template <typename Handle>
  void name(VkDevice device, VkObjectType type, Handle handle, const std::string& name) const {
    if (set_name_) name_object(device, type, std::bit_cast<std::uint64_t>(handle), name);
  }
  // The commands recorded between the two are shown under `name`. Nothing happens unless names are on.
  void begin_label(VkCommandBuffer commands, const std::string& name) const;
  void end_label(VkCommandBuffer commands) const;

  // What the host is at, "pass …" or "buffer …": named in the messages of the layer while the object lives.
  class Work {
   public:
    Work(Instance& instance, std::string_view kind, std::string_view name);
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

   private:
    std::vector<std::string>* stack_;
  };

 private:
  struct Listener {
    std::vector<std::string>* messages = nullptr;
    std::vector<std::string> work;  // the innermost last
  };
  static VkBool32 VKAPI_CALL hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT,
                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* listener);
  void name_object(VkDevice device, VkObjectType type, std::uint64_t handle, const std::string& name) const;

  static void destroy_messenger(VkInstance instance, VkDebugUtilsMessengerEXT messenger, const VkAllocationCallbacks*);

  std::unique_ptr<Listener> listener_;  // null without messages; the first member: the instance's end is heard too
  UniqueInstance instance_;
  Unique<VkDebugUtilsMessengerEXT, destroy_messenger, VkInstance> messenger_;
  PFN_vkSetDebugUtilsObjectNameEXT set_name_ = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT begin_label_ = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT end_label_ = nullptr;
};

}  // namespace subpixel::gpu
