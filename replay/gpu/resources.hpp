// Buffers, images and samplers. Each remembers its last use, from which the next pass derives its barrier.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "replay/gpu/device.hpp"

namespace subpixel::gpu {

// The last access of a resource: what the next one has to wait for.
struct AccessState {
  VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
  VkAccessFlags2 access = VK_ACCESS_2_NONE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

// Lists a buffer's address with its device for as long as the buffer lives.
class AddressEntry {
 public:
  AddressEntry() = default;
  AddressEntry(Device& device, VkDeviceAddress address, VkDeviceSize bytes, const std::string& name)
      : device_(&device), address_(address) {
    device.add_address(address, bytes, name);
  }
  ~AddressEntry() {
    if (device_ != nullptr) device_->remove_address(address_);
  }
  AddressEntry(AddressEntry&& other) noexcept
      : device_(std::exchange(other.device_, nullptr)), address_(other.address_) {}
  AddressEntry& operator=(AddressEntry&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(address_, other.address_);
    return *this;
  }

 private:
  Device* device_ = nullptr;
  VkDeviceAddress address_ = 0;
};

// Host-visible and coherent: on a CPU device that is the device's memory, elsewhere the mapped window of it.
// Usable as storage, uniform, index, indirect and transfer buffer, and by address.
class Buffer {
 public:
  Buffer() = default;
  // Zero-filled. `bytes` 0 makes a buffer of 16 bytes, so that an empty scene binds like any other.
  Buffer(Device& device, std::string name, VkDeviceSize bytes);

  const std::string& name() const { return name_; }
  VkBuffer handle() const { return buffer_.get(); }
  VkDeviceSize bytes() const { return bytes_; }
  std::span<std::byte> mapped() const { return {static_cast<std::byte*>(mapped_), static_cast<std::size_t>(bytes_)}; }
  // The mapping seen as elements of T; the device must be idle.
  template <typename T>
  std::span<T> as() const {
    return {static_cast<T*>(mapped_), static_cast<std::size_t>(bytes_) / sizeof(T)};
  }
  explicit operator bool() const { return bool{buffer_}; }

  AccessState state;

 private:
  // Who hands out an address declares its use (pass_recorder.hpp).
  friend class AddressUses;
  friend class AddressTable;
  friend class PassRecorder;
  VkDeviceAddress address() const { return address_; }

  std::string name_;
  UniqueMemory memory_;  // freed after what is bound to it
  UniqueBuffer buffer_;
  VkDeviceSize bytes_ = 0;
  VkDeviceAddress address_ = 0;
  AddressEntry listed_;
  void* mapped_ = nullptr;
};

struct ImageDescription {
  std::string name;
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  std::uint32_t width = 1, height = 1, mips = 1, layers = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  VkImageUsageFlags usage = 0;  // transfer source and destination are always added
  bool array = false;           // seen as an array by shaders even with one layer
};

class Image {
 public:
  Image() = default;
  Image(Device& device, const ImageDescription& description);

  const ImageDescription& description() const { return description_; }
  VkImage handle() const { return image_.get(); }
  VkImageView view() const { return view_.get(); }
  // One layer, as an attachment.
  VkImageView layer_view(std::uint32_t layer) const { return layer_views_[layer].get(); }
  VkDeviceSize bytes() const { return bytes_; }  // what the device allocated
  VkImageAspectFlags aspect() const;
  explicit operator bool() const { return bool{image_}; }

  AccessState state;

 private:
  ImageDescription description_;
  UniqueMemory memory_;  // freed after what is bound to it
  UniqueImage image_;
  UniqueImageView view_;
  std::vector<UniqueImageView> layer_views_;
  VkDeviceSize bytes_ = 0;
};

struct SamplerDescription {
  VkFilter magnify = VK_FILTER_LINEAR, minify = VK_FILTER_LINEAR;
  VkSamplerMipmapMode mipmap = VK_SAMPLER_MIPMAP_MODE_LINEAR;
  VkSamplerAddressMode address_u = VK_SAMPLER_ADDRESS_MODE_REPEAT, address_v = VK_SAMPLER_ADDRESS_MODE_REPEAT;
};
inline constexpr SamplerDescription kNearestClamped{
    VK_FILTER_NEAREST, VK_FILTER_NEAREST, VK_SAMPLER_MIPMAP_MODE_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
    VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};

class Sampler {
 public:
  Sampler() = default;
  Sampler(Device& device, const SamplerDescription& description);
  VkSampler handle() const { return sampler_.get(); }

 private:
  UniqueSampler sampler_;
};

std::uint32_t bytes_per_texel(VkFormat format);

// Fills one mip level of one layer from tightly packed texels; waits.
void upload(Device& device, Image& image, std::uint32_t mip, std::uint32_t layer, std::span<const std::byte> texels);
// The texels of mip 0 of one layer, tightly packed, rows top to bottom; waits.
std::vector<std::byte> download(Device& device, Image& image, std::uint32_t layer = 0);
// Copies `rows` rows of one layer between images of one width and format; waits.
void copy_rows(Device& device, Image& from, std::uint32_t first, Image& to, std::uint32_t to_first, std::uint32_t rows);

}  // namespace subpixel::gpu
