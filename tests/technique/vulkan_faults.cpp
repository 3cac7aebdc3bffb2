#include "tests/technique/vulkan_faults.hpp"

#include <vulkan/vulkan.h>

#include <mutex>

namespace subpixel::tests {
namespace {

std::mutex mutex;  // pipelines are made on threads of their own
std::size_t fail_at = 0, calls = 0;
std::map<std::string, int> live;

// Whether this call is the one to fail.
bool fails() {
  const std::lock_guard lock(mutex);
  return ++calls == fail_at;
}

VkResult made(VkResult result, const char* what) {
  const std::lock_guard lock(mutex);
  if (result >= 0) ++live[what];
  return result;
}

template <typename Handle>
void destroyed(Handle handle, const char* what) {
  const std::lock_guard lock(mutex);
  if (handle != VK_NULL_HANDLE && --live[what] == 0) live.erase(what);
}

}  // namespace

void fail_vulkan_call(std::size_t number) {
  fail_at = number;
  calls = 0;
}
std::size_t vulkan_calls() {
  return calls;
}
std::map<std::string, int> live_vulkan_objects() {
  return live;
}

}  // namespace subpixel::tests

using namespace subpixel::tests;

// The calls whose functions differ in the type of what they make alone.
#define SUBPIXEL_OBJECT(Name)                                                                                     \
  VkResult __real_vkCreate##Name(VkDevice, const Vk##Name##CreateInfo*, const VkAllocationCallbacks*, Vk##Name*); \
  VkResult __wrap_vkCreate##Name(VkDevice device, const Vk##Name##CreateInfo* info,                               \
                                 const VkAllocationCallbacks* allocator, Vk##Name* object) {                      \
    if (fails()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;                                                            \
    return made(__real_vkCreate##Name(device, info, allocator, object), #Name);                                   \
  }                                                                                                               \
  void __real_vkDestroy##Name(VkDevice, Vk##Name, const VkAllocationCallbacks*);                                  \
  void __wrap_vkDestroy##Name(VkDevice device, Vk##Name object, const VkAllocationCallbacks* allocator) {         \
    destroyed(object, #Name);                                                                                     \
    __real_vkDestroy##Name(device, object, allocator);                                                            \
  }
#define SUBPIXEL_PIPELINES(Kind)                                                                                  \
  VkResult __real_vkCreate##Kind##Pipelines(VkDevice, VkPipelineCache, std::uint32_t,                             \
                                            const Vk##Kind##PipelineCreateInfo*, const VkAllocationCallbacks*,    \
                                            VkPipeline*);                                                         \
  VkResult __wrap_vkCreate##Kind##Pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,          \
                                            const Vk##Kind##PipelineCreateInfo* infos,                            \
                                            const VkAllocationCallbacks* allocator, VkPipeline* pipelines) {      \
    if (fails()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;                                                            \
    return made(__real_vkCreate##Kind##Pipelines(device, cache, count, infos, allocator, pipelines), "Pipeline"); \
  }

// NOLINTBEGIN: the linker's names
extern "C" {
SUBPIXEL_OBJECT(Buffer)
SUBPIXEL_OBJECT(Image)
SUBPIXEL_OBJECT(ImageView)
SUBPIXEL_OBJECT(Sampler)
SUBPIXEL_OBJECT(ShaderModule)
SUBPIXEL_OBJECT(PipelineLayout)
SUBPIXEL_OBJECT(DescriptorSetLayout)
SUBPIXEL_OBJECT(DescriptorPool)
SUBPIXEL_OBJECT(RenderPass)
SUBPIXEL_OBJECT(Framebuffer)
SUBPIXEL_OBJECT(CommandPool)
SUBPIXEL_OBJECT(Fence)
SUBPIXEL_OBJECT(QueryPool)
SUBPIXEL_PIPELINES(Compute)
SUBPIXEL_PIPELINES(Graphics)

void __real_vkDestroyPipeline(VkDevice, VkPipeline, const VkAllocationCallbacks*);
void __wrap_vkDestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks* allocator) {
  destroyed(pipeline, "Pipeline");
  __real_vkDestroyPipeline(device, pipeline, allocator);
}

VkResult __real_vkCreateInstance(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance*);
VkResult __wrap_vkCreateInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                 VkInstance* instance) {
  if (fails()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return made(__real_vkCreateInstance(info, allocator, instance), "Instance");
}
void __real_vkDestroyInstance(VkInstance, const VkAllocationCallbacks*);
void __wrap_vkDestroyInstance(VkInstance instance, const VkAllocationCallbacks* allocator) {
  destroyed(instance, "Instance");
  __real_vkDestroyInstance(instance, allocator);
}

VkResult __real_vkCreateDevice(VkPhysicalDevice, const VkDeviceCreateInfo*, const VkAllocationCallbacks*, VkDevice*);
VkResult __wrap_vkCreateDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                               const VkAllocationCallbacks* allocator, VkDevice* device) {
  if (fails()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return made(__real_vkCreateDevice(physical, info, allocator, device), "Device");
}
void __real_vkDestroyDevice(VkDevice, const VkAllocationCallbacks*);
void __wrap_vkDestroyDevice(VkDevice device, const VkAllocationCallbacks* allocator) {
  destroyed(device, "Device");
  __real_vkDestroyDevice(device, allocator);
}

VkResult __real_vkAllocateMemory(VkDevice, const VkMemoryAllocateInfo*, const VkAllocationCallbacks*, VkDeviceMemory*);
VkResult __wrap_vkAllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                 const VkAllocationCallbacks* allocator, VkDeviceMemory* memory) {
  if (fails()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return made(__real_vkAllocateMemory(device, info, allocator, memory), "Memory");
}
void __real_vkFreeMemory(VkDevice, VkDeviceMemory, const VkAllocationCallbacks*);
void __wrap_vkFreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* allocator) {
  destroyed(memory, "Memory");
  __real_vkFreeMemory(device, memory, allocator);
}

// What is freed with its pool, or not at all.
VkResult __real_vkAllocateCommandBuffers(VkDevice, const VkCommandBufferAllocateInfo*, VkCommandBuffer*);
VkResult __wrap_vkAllocateCommandBuffers(VkDevice device, const VkCommandBufferAllocateInfo* info,
                                         VkCommandBuffer* buffers) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkAllocateCommandBuffers(device, info, buffers);
}
VkResult __real_vkAllocateDescriptorSets(VkDevice, const VkDescriptorSetAllocateInfo*, VkDescriptorSet*);
VkResult __wrap_vkAllocateDescriptorSets(VkDevice device, const VkDescriptorSetAllocateInfo* info,
                                         VkDescriptorSet* sets) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkAllocateDescriptorSets(device, info, sets);
}
VkResult __real_vkBindBufferMemory(VkDevice, VkBuffer, VkDeviceMemory, VkDeviceSize);
VkResult __wrap_vkBindBufferMemory(VkDevice device, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkBindBufferMemory(device, buffer, memory, offset);
}
VkResult __real_vkBindImageMemory(VkDevice, VkImage, VkDeviceMemory, VkDeviceSize);
VkResult __wrap_vkBindImageMemory(VkDevice device, VkImage image, VkDeviceMemory memory, VkDeviceSize offset) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkBindImageMemory(device, image, memory, offset);
}
VkResult __real_vkMapMemory(VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkMemoryMapFlags, void**);
VkResult __wrap_vkMapMemory(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize size,
                            VkMemoryMapFlags flags, void** mapped) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkMapMemory(device, memory, offset, size, flags, mapped);
}
VkResult __real_vkQueueSubmit(VkQueue, std::uint32_t, const VkSubmitInfo*, VkFence);
VkResult __wrap_vkQueueSubmit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
  return fails() ? VK_ERROR_OUT_OF_DEVICE_MEMORY : __real_vkQueueSubmit(queue, count, submits, fence);
}
}
// NOLINTEND
