#include "replay/gpu/device.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "base/error.hpp"
#include "replay/gpu/pipeline.hpp"
#include "replay/gpu/renderdoc.hpp"

namespace subpixel::gpu {
namespace {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) {
      const auto colon = line.find(':');
      if (colon != std::string::npos) return line.substr(line.find_first_not_of(' ', colon + 1));
    }
  }
  return "unknown";
}

const char* result_name(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_DEVICE_LOST:
      return "device lost";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialization failed";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no compatible driver";
    default:
      return nullptr;
  }
}

constexpr const char* kRequiredExtensions[] = {
    VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME,
};

struct Features {
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT order{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_FEATURES_EXT};
  VkPhysicalDeviceFragmentShaderInterlockFeaturesEXT interlock{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FRAGMENT_SHADER_INTERLOCK_FEATURES_EXT};
  Features() {
    core.pNext = &v12;
    v12.pNext = &v13;
  }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

// The features every pass may rely on: each named once, both for the probe and for the device's creation.
struct FeatureNeed {
  const char* name;
  VkBool32& (*get)(Features&);
};
constexpr FeatureNeed kNeeds[] = {
    {"bufferDeviceAddress", [](Features& f) -> VkBool32& { return f.v12.bufferDeviceAddress; }},
    {"scalarBlockLayout", [](Features& f) -> VkBool32& { return f.v12.scalarBlockLayout; }},
    {"maintenance4", [](Features& f) -> VkBool32& { return f.v13.maintenance4; }},  // LocalSizeId, which glslang emits
    {"synchronization2", [](Features& f) -> VkBool32& { return f.v13.synchronization2; }},
};

bool has_extension(VkPhysicalDevice physical, const char* wanted) {
  std::uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data());
  return std::ranges::any_of(extensions,
                             [&](const auto& extension) { return std::strcmp(extension.extensionName, wanted) == 0; });
}

bool has_ordered_attachments(VkPhysicalDevice physical) {
  if (!has_extension(physical, VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME)) return false;
  Features available;
  available.v13.pNext = &available.order;
  vkGetPhysicalDeviceFeatures2(physical, &available.core);
  return available.order.rasterizationOrderColorAttachmentAccess == VK_TRUE;
}

bool has_pixel_interlock(VkPhysicalDevice physical) {
  if (!has_extension(physical, VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME)) return false;
  Features available;
  available.v13.pNext = &available.interlock;
  vkGetPhysicalDeviceFeatures2(physical, &available.core);
  return available.interlock.fragmentShaderPixelInterlock == VK_TRUE;
}

template <VkBool32 VkPhysicalDeviceFeatures::*feature>
bool has_feature(VkPhysicalDevice physical) {
  VkPhysicalDeviceFeatures available;
  vkGetPhysicalDeviceFeatures(physical, &available);
  return available.*feature == VK_TRUE;
}

bool has_fragment_subgroups(VkPhysicalDevice physical) {
  VkPhysicalDeviceSubgroupProperties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups};
  vkGetPhysicalDeviceProperties2(physical, &properties);
  constexpr VkSubgroupFeatureFlags kWanted = VK_SUBGROUP_FEATURE_VOTE_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
  return (subgroups.supportedOperations & kWanted) == kWanted &&
         (subgroups.supportedStages & VK_SHADER_STAGE_FRAGMENT_BIT) != 0;
}

bool has_eight_attachments(VkPhysicalDevice physical) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical, &properties);
  return properties.limits.maxColorAttachments >= 8 && properties.limits.maxFragmentOutputAttachments >= 8;
}

// What some passes need, and where the device's description says that it is there and used.
struct NeedOfParts {
  const char* name;
  bool (*is_there)(VkPhysicalDevice);
  bool DeviceInfo::*used;
};
constexpr NeedOfParts kNeedsOfParts[] = {
    {kOrderedAttachments, has_ordered_attachments, &DeviceInfo::ordered_attachments},
    {kPixelInterlock, has_pixel_interlock, &DeviceInfo::pixel_interlock},
    {kDoubles, has_feature<&VkPhysicalDeviceFeatures::shaderFloat64>, &DeviceInfo::doubles},
    {kFragmentStores, has_feature<&VkPhysicalDeviceFeatures::fragmentStoresAndAtomics>, &DeviceInfo::fragment_stores},
    {kFragmentSubgroups, has_fragment_subgroups, &DeviceInfo::fragment_subgroups},
    {kEightAttachments, has_eight_attachments, &DeviceInfo::eight_attachments},
};

std::vector<std::string> missing_needs(VkPhysicalDevice physical) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical, &properties);
  if (properties.apiVersion < VK_API_VERSION_1_3) return {"Vulkan 1.3"};
  std::vector<std::string> missing;
  for (const char* wanted : kRequiredExtensions)
    if (!has_extension(physical, wanted)) missing.emplace_back(wanted);
  Features available;
  vkGetPhysicalDeviceFeatures2(physical, &available.core);
  for (const auto& need : kNeeds)
    if (!need.get(available)) missing.emplace_back(need.name);
  return missing;
}

bool is_lavapipe(VkPhysicalDevice physical) {
  VkPhysicalDeviceVulkan12Properties v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &v12};
  vkGetPhysicalDeviceProperties2(physical, &properties);
  return v12.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
}

std::string device_name(VkPhysicalDevice physical) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical, &properties);
  return properties.deviceName;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
  std::uint32_t count = 0;
  const VkResult found = vkEnumeratePhysicalDevices(instance, &count, nullptr);
  if (found == VK_ERROR_INITIALIZATION_FAILED || (found == VK_SUCCESS && count == 0))
    throw DeviceError("device", "none of the installed Vulkan drivers has a device (lavapipe: mesa-vulkan-drivers)",
                      "vkEnumeratePhysicalDevices");
  check(found, "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
  return devices;
}

VkPhysicalDevice first_lavapipe(const std::vector<VkPhysicalDevice>& devices) {
  std::string refused;
  for (VkPhysicalDevice device : devices) {
    const std::string before = refused.empty() ? "" : "; ";
    if (!is_lavapipe(device)) {
      refused += fmt::format("{}{} is not lavapipe", before, device_name(device));
      continue;
    }
    const auto missing = missing_needs(device);
    if (missing.empty()) return device;
    refused += fmt::format("{}{} lacks {}", before, device_name(device), fmt::join(missing, ", "));
  }
  // RenderDoc hides buffer addresses, and with them Vulkan 1.3, where it can't capture them: on lavapipe, so far.
  if (RenderDoc::of_process()) refused += ", as RenderDoc shows it";
  throw DeviceError("device", "no usable Vulkan device: " + refused, "feature probe");
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

VkPhysicalDevice named_device(const std::vector<VkPhysicalDevice>& devices, const std::string& wanted) {
  std::string all;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const std::string name = device_name(devices[i]);
    if (wanted == std::to_string(i) || lower_case(name).find(lower_case(wanted)) != std::string::npos)
      return devices[i];
    all += fmt::format("{}{} {}", all.empty() ? "" : ", ", i, name);
  }
  throw DeviceError("device", fmt::format("none is '{}'; there are: {}", wanted, all), "--device");
}

}  // namespace

std::vector<VulkanDevice> vulkan_devices() {
  const Instance instance(false, nullptr);
  std::vector<VulkanDevice> found;
  for (VkPhysicalDevice device : physical_devices(instance.get())) {
    VulkanDevice& listed =
        found.emplace_back(VulkanDevice{device_name(device), is_lavapipe(device), missing_needs(device), {}});
    if (!listed.missing.empty()) continue;
    for (const NeedOfParts& need : kNeedsOfParts)
      if (!need.is_there(device)) listed.missing_in_part.emplace_back(need.name);
  }
  return found;
}

void check(VkResult result, std::string_view call) {
  if (result >= VK_SUCCESS) return;
  const char* name = result_name(result);
  throw DeviceError("device", name ? name : fmt::format("Vulkan error {}", static_cast<int>(result)),
                    std::string(call));
}

Device::Device(const DeviceOptions& options)
    : shaders_(options.shaders), instance_(options.names, options.validation_messages) {
  choose_physical(options);
  create_device();
  pipelines_ = std::make_unique<PipelineCache>(*this);
}

void Device::choose_physical(const DeviceOptions& options) {
  const std::vector<VkPhysicalDevice> devices = physical_devices(instance_.get());
  if (!options.device.empty()) {
    physical_ = named_device(devices, options.device);
    if (const auto missing = missing_needs(physical_); !missing.empty())
      throw DeviceError("device", fmt::format("{} lacks {}", device_name(physical_), fmt::join(missing, ", ")),
                        "feature probe");
  } else {
    physical_ = first_lavapipe(devices);
  }

  VkPhysicalDeviceVulkan12Properties v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties maintenance3{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, &v12};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &maintenance3};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  const auto& core = properties.properties;
  info_.device = core.deviceName;
  info_.driver = v12.driverName;
  info_.driver_version = v12.driverInfo;
  info_.cpu_model = cpu_model();
  info_.is_cpu = core.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info_.max_storage_buffer_range = core.limits.maxStorageBufferRange;
  if (options.largest_range > 0)
    info_.max_storage_buffer_range = std::min(info_.max_storage_buffer_range, options.largest_range);
  info_.max_buffer_size = maintenance3.maxMemoryAllocationSize;
  info_.max_image_dimension = core.limits.maxImageDimension2D;
  for (const NeedOfParts& need : kNeedsOfParts)
    info_.*need.used =
        std::ranges::find(options.without, need.name) == options.without.end() && need.is_there(physical_);
  timestamp_period_ns_ = core.limits.timestampPeriod;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
}

void Device::create_device() {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (queue_family_ = 0; queue_family_ < count; ++queue_family_)
    if ((families[queue_family_].queueFlags & kWanted) == kWanted) break;
  if (queue_family_ == count)
    throw DeviceError("device", "no queue for graphics and compute", "vkGetPhysicalDeviceQueueFamilyProperties");

  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  Features enabled;
  for (const auto& need : kNeeds) need.get(enabled) = VK_TRUE;
  enabled.core.features.shaderFloat64 = info_.doubles ? VK_TRUE : VK_FALSE;
  enabled.core.features.fragmentStoresAndAtomics = info_.fragment_stores ? VK_TRUE : VK_FALSE;
  VkDeviceCreateInfo create{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &enabled.core};
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  std::vector<const char*> extensions(std::begin(kRequiredExtensions), std::end(kRequiredExtensions));
  if (info_.ordered_attachments) {
    extensions.push_back(VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME);
    enabled.order.rasterizationOrderColorAttachmentAccess = VK_TRUE;
    enabled.v13.pNext = &enabled.order;
  }
  if (info_.pixel_interlock) {
    extensions.push_back(VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME);
    enabled.interlock.fragmentShaderPixelInterlock = VK_TRUE;
    enabled.interlock.pNext = enabled.v13.pNext;
    enabled.v13.pNext = &enabled.interlock;
  }
  create.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  check(vkCreateDevice(physical_, &create, nullptr, device_.made_by({})), "vkCreateDevice");
  vkGetDeviceQueue(handle(), queue_family_, 0, &queue_);
  push_descriptor_set =
      reinterpret_cast<PFN_vkCmdPushDescriptorSetKHR>(vkGetDeviceProcAddr(handle(), "vkCmdPushDescriptorSetKHR"));

  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = queue_family_;
  check(vkCreateCommandPool(handle(), &pool, nullptr, command_pool_.made_by(handle())), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = command_pool_.get();
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(handle(), &allocate, &command_buffer_), "vkAllocateCommandBuffers");
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  check(vkCreateFence(handle(), &fence, nullptr, fence_.made_by(handle())), "vkCreateFence");
  VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = 2;
  check(vkCreateQueryPool(handle(), &queries, nullptr, timestamps_.made_by(handle())), "vkCreateQueryPool");
}

Device::~Device() {
  vkDeviceWaitIdle(device_.get());
}

double Device::run(const std::string& name, const std::function<void(VkCommandBuffer)>& record) {
  const Instance::Work work(instance_, "pass", name);
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(command_buffer_, &begin), "vkBeginCommandBuffer");
  if (!info_.is_cpu) {
    vkCmdResetQueryPool(command_buffer_, timestamps_.get(), 0, 2);
    vkCmdWriteTimestamp2(command_buffer_, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, timestamps_.get(), 0);
  }
  instance_.begin_label(command_buffer_, name);
  record(command_buffer_);
  instance_.end_label(command_buffer_);
  if (!info_.is_cpu) vkCmdWriteTimestamp2(command_buffer_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timestamps_.get(), 1);
  check(vkEndCommandBuffer(command_buffer_), "vkEndCommandBuffer");

  const auto start = std::chrono::steady_clock::now();
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &command_buffer_;
  const VkFence fence = fence_.get();
  check(vkQueueSubmit(queue_, 1, &submit, fence), "vkQueueSubmit");
  check(vkWaitForFences(handle(), 1, &fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  const double wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  check(vkResetFences(handle(), 1, &fence), "vkResetFences");
  total_ms_ += wall_ms;
  if (info_.is_cpu) return wall_ms;
  std::uint64_t ticks[2] = {};
  check(vkGetQueryPoolResults(handle(), timestamps_.get(), 0, 2, sizeof ticks, ticks, sizeof ticks[0],
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  return static_cast<double>(ticks[1] - ticks[0]) * static_cast<double>(timestamp_period_ns_) * 1e-6;
}

double Device::run_on_host(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  const double wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  total_ms_ += wall_ms;
  return wall_ms;
}

std::uint32_t Device::memory_type(std::uint32_t allowed_types, VkMemoryPropertyFlags required,
                                  VkMemoryPropertyFlags preferred) const {
  for (const VkMemoryPropertyFlags wanted : {required | preferred, required}) {
    for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i) {
      if ((allowed_types >> i & 1u) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    }
  }
  throw DeviceError("device", "no memory type fits", "vkGetPhysicalDeviceMemoryProperties");
}

void Device::add_address(VkDeviceAddress address, VkDeviceSize bytes, std::string name) {
  addresses_[address] = {address, bytes, std::move(name)};
}

std::optional<Device::AddressedBuffer> Device::buffer_at(VkDeviceAddress address) const {
  auto found = addresses_.upper_bound(address);
  if (found == addresses_.begin()) return std::nullopt;
  --found;
  if (address - found->first >= found->second.bytes) return std::nullopt;
  return found->second;
}

}  // namespace subpixel::gpu
