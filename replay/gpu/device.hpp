// The Vulkan device a replay runs on: chosen, probed for what the passes need, and refused in clear words.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "replay/gpu/handle.hpp"
#include "replay/gpu/instance.hpp"
#include "replay/gpu/memory_ledger.hpp"
#include "replay/gpu/shader_library.hpp"

namespace subpixel::gpu {

struct DeviceOptions {
  // The one of this number (vulkan_devices()), or the first whose name has this in it; empty: lavapipe, so that results
  // are comparable from machine to machine.
  std::string device;
  // The folder all shaders are read from instead of the embedded ones (ShaderLibrary); empty: those.
  std::filesystem::path shaders = shader_folder_of_environment();
  // Of the needs of parts (kOrderedAttachments and so on), those that are left alone though the device has them, so
  // that a test takes the other path.
  std::vector<std::string> without;
  // Bound ranges end there, so that a test goes beyond them; 0: where the device's do.
  VkDeviceSize largest_range = 0;
  bool names = false;  // of buffers, images, pipelines and passes reach Vulkan, for RenderDoc and layers
  // Turns the Khronos validation layer on, and names, and takes what it says until the device has ended (Instance).
  std::vector<std::string>* validation_messages = nullptr;
};

struct DeviceInfo {
  std::string device, driver, driver_version, cpu_model;
  bool is_cpu = false;
  VkDeviceSize max_storage_buffer_range = 0;
  VkDeviceSize max_buffer_size = 0;
  std::uint32_t max_image_dimension = 0;
  // What only some passes need, by the names below.
  bool ordered_attachments = false;
  bool pixel_interlock = false;
  bool doubles = false;
  bool fragment_stores = false;
  bool fragment_subgroups = false;
  bool eight_attachments = false;  // else four
};

// A device that Vulkan has, in the order of its loader.
struct VulkanDevice {
  std::string name;
  bool is_lavapipe = false;
  std::vector<std::string> missing;          // of what all passes need
  std::vector<std::string> missing_in_part;  // of what only some passes need
};
// What only some passes need: these take another way without, to the same bits, or refuse the device by name.
// VK_EXT_rasterization_order_attachment_access: visibility in one geometry pass; the ordered passes of techniques.
inline constexpr const char* kOrderedAttachments = "rasterizationOrderColorAttachmentAccess";
// VK_EXT_fragment_shader_interlock: ordered passes use it for state in buffers.
inline constexpr const char* kPixelInterlock = "fragmentShaderPixelInterlock";
inline constexpr const char* kDoubles = "shaderFloat64";                    // set-up; else the host's threads do it
inline constexpr const char* kFragmentStores = "fragmentStoresAndAtomics";  // lists, counters
inline constexpr const char* kFragmentSubgroups = "votes and ballots in subgroups of fragments";  // small triangles
inline constexpr const char* kEightAttachments = "8 colour attachments";  // 16 samples at a time; else 8

// Throws DeviceError when there is no Vulkan or no device.
std::vector<VulkanDevice> vulkan_devices();

class PipelineCache;

class Device {
 public:
  // Throws DeviceError when there is no Vulkan, no such device, or a feature is missing (all missing are named)
  // or the validation layer is wanted and not installed; InputError when a shader of the folder is missing or broken.
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const { return info_; }
  VkDevice handle() const { return device_.get(); }
  Instance& instance() { return instance_; }
  VkPhysicalDevice physical() const { return physical_; }
  const ShaderLibrary& shaders() const { return shaders_; }
  PipelineCache& pipelines() { return *pipelines_; }
  MemoryLedger& ledger() { return ledger_; }

  template <typename Handle>
  void name(VkObjectType type, Handle object, const std::string& name) const {
    instance_.name(device_.get(), type, object, name);
  }

  // Records with `record`, submits and waits; `name` is the pass's, for messages and tools. Returns the milliseconds
  // the device took: the wall clock on a CPU device, where the queue's work runs on this machine's cores; timestamps
  // elsewhere. Throws DeviceError.
  double run(const std::string& name, const std::function<void(VkCommandBuffer)>& record);
  // A pass's work on the host in place of the device, timed likewise.
  double run_on_host(const std::function<void()>& work);
  // Milliseconds of all runs so far.
  double total_ms() const { return total_ms_; }

  // A memory type with all of `required`, preferring `preferred`. Throws DeviceError.
  std::uint32_t memory_type(std::uint32_t allowed_types, VkMemoryPropertyFlags required,
                            VkMemoryPropertyFlags preferred) const;

  // Buffers that shaders may be given by address: who passes one on has to say so, or its barriers are missing.
  void add_address(VkDeviceAddress address, VkDeviceSize bytes, std::string name);
  void remove_address(VkDeviceAddress address) { addresses_.erase(address); }
  struct AddressedBuffer {
    VkDeviceAddress address = 0;
    VkDeviceSize bytes = 0;
    std::string name;
  };
  // The live buffer that the address lies in.
  std::optional<AddressedBuffer> buffer_at(VkDeviceAddress address) const;

  PFN_vkCmdPushDescriptorSetKHR push_descriptor_set = nullptr;

 private:
  void choose_physical(const DeviceOptions& options);
  void create_device();

  ShaderLibrary shaders_;
  Instance instance_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  UniqueDevice device_;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  UniqueCommandPool command_pool_;
  VkCommandBuffer command_buffer_ = VK_NULL_HANDLE;
  UniqueFence fence_;
  UniqueQueryPool timestamps_;
  float timestamp_period_ns_ = 1;
  VkPhysicalDeviceMemoryProperties memory_{};
  double total_ms_ = 0;
  MemoryLedger ledger_;
  DeviceInfo info_;
  std::map<VkDeviceAddress, AddressedBuffer> addresses_;
  std::unique_ptr<PipelineCache> pipelines_;
};

}  // namespace subpixel::gpu
