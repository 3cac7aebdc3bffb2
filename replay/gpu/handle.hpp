// The one owner of a Vulkan object. What a constructor has made so far is destroyed when it throws.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "replay/gpu/vulkan.hpp"

namespace subpixel::gpu {

// Instance and device, which nothing else has to be named for to destroy them.
using NoParent = std::monostate;

// `destroy` is the vkDestroy… or vkFree… of the handle's type.
template <typename Handle, auto destroy, typename Parent = VkDevice>
class Unique {
 public:
  Unique() = default;
  ~Unique() { reset(); }
  Unique(Unique&& other) noexcept
      : parent_(other.parent_), handle_(std::exchange(other.handle_, Handle{VK_NULL_HANDLE})) {}
  Unique& operator=(Unique&& other) noexcept {
    std::swap(parent_, other.parent_);
    std::swap(handle_, other.handle_);
    return *this;
  }

  Handle get() const { return handle_; }
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
  // Where the call that makes an object of `parent`'s puts the handle; one that was held is destroyed.
  Handle* made_by(Parent parent) {
    reset();
    parent_ = parent;
    return &handle_;
  }

 private:
  void reset() {
    const Handle handle = std::exchange(handle_, Handle{VK_NULL_HANDLE});
    if (handle == VK_NULL_HANDLE) return;
    if constexpr (std::is_same_v<Parent, NoParent>)
      destroy(handle, nullptr);
    else
      destroy(parent_, handle, nullptr);
  }

  Parent parent_{};
  Handle handle_ = VK_NULL_HANDLE;
};

using UniqueInstance = Unique<VkInstance, vkDestroyInstance, NoParent>;
using UniqueDevice = Unique<VkDevice, vkDestroyDevice, NoParent>;
using UniqueBuffer = Unique<VkBuffer, vkDestroyBuffer>;
using UniqueImage = Unique<VkImage, vkDestroyImage>;
using UniqueImageView = Unique<VkImageView, vkDestroyImageView>;
using UniqueMemory = Unique<VkDeviceMemory, vkFreeMemory>;
using UniqueSampler = Unique<VkSampler, vkDestroySampler>;
using UniqueShaderModule = Unique<VkShaderModule, vkDestroyShaderModule>;
using UniquePipeline = Unique<VkPipeline, vkDestroyPipeline>;
using UniquePipelineLayout = Unique<VkPipelineLayout, vkDestroyPipelineLayout>;
using UniqueSetLayout = Unique<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using UniqueDescriptorPool = Unique<VkDescriptorPool, vkDestroyDescriptorPool>;
using UniqueRenderPass = Unique<VkRenderPass, vkDestroyRenderPass>;
using UniqueFramebuffer = Unique<VkFramebuffer, vkDestroyFramebuffer>;
using UniqueCommandPool = Unique<VkCommandPool, vkDestroyCommandPool>;
using UniqueFence = Unique<VkFence, vkDestroyFence>;
using UniqueQueryPool = Unique<VkQueryPool, vkDestroyQueryPool>;

}  // namespace subpixel::gpu
