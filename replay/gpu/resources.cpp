#include "replay/gpu/resources.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "base/error.hpp"

namespace subpixel::gpu {
namespace {

UniqueMemory allocate(Device& device, const VkMemoryRequirements& needs, VkMemoryPropertyFlags required,
                      VkMemoryPropertyFlags preferred, bool addressable, const std::string& name) {
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, addressable ? &flags : nullptr};
  info.allocationSize = needs.size;
  info.memoryTypeIndex = device.memory_type(needs.memoryTypeBits, required, preferred);
  UniqueMemory memory;
  const VkResult result = vkAllocateMemory(device.handle(), &info, nullptr, memory.made_by(device.handle()));
  if (result < 0) throw DeviceError("device", fmt::format("can't allocate {} bytes", needs.size), name);
  return memory;
}

}  // namespace

Buffer::Buffer(Device& device, std::string name, VkDeviceSize bytes)
    : name_(std::move(name)), bytes_(bytes == 0 ? 16 : (bytes + 15) / 16 * 16) {
  if (bytes_ > device.info().max_buffer_size)
    throw DeviceError(
        "device",
        fmt::format("a buffer of {} bytes is over the device's limit of {}", bytes_, device.info().max_buffer_size),
        name_);
  const Instance::Work work(device.instance(), "buffer", name_);
  VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  create.size = bytes_;
  create.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  check(vkCreateBuffer(device.handle(), &create, nullptr, buffer_.made_by(device.handle())), "vkCreateBuffer");
  device.name(VK_OBJECT_TYPE_BUFFER, buffer_.get(), name_);
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.handle(), buffer_.get(), &needs);
  memory_ = allocate(device, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                     VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, true, name_);
  check(vkBindBufferMemory(device.handle(), buffer_.get(), memory_.get(), 0), "vkBindBufferMemory");
  check(vkMapMemory(device.handle(), memory_.get(), 0, VK_WHOLE_SIZE, 0, &mapped_), "vkMapMemory");
  std::memset(mapped_, 0, bytes_);
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer_.get();
  address_ = vkGetBufferDeviceAddress(device.handle(), &address);
  listed_ = AddressEntry(device, address_, bytes_, name_);
}

VkImageAspectFlags Image::aspect() const {
  return description_.format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Image::Image(Device& device, const ImageDescription& description) : description_(description) {
  const auto limit = device.info().max_image_dimension;
  if (description.width > limit || description.height > limit)
    throw DeviceError(
        "device",
        fmt::format("{}x{} is over the device's image limit of {}", description.width, description.height, limit),
        description.name);
  const Instance::Work work(device.instance(), "image", description.name);
  VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = description.format;
  create.extent = {description.width, description.height, 1};
  create.mipLevels = description.mips;
  create.arrayLayers = description.layers;
  create.samples = description.samples;
  create.tiling = VK_IMAGE_TILING_OPTIMAL;
  create.usage = description.usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  check(vkCreateImage(device.handle(), &create, nullptr, image_.made_by(device.handle())), "vkCreateImage");
  device.name(VK_OBJECT_TYPE_IMAGE, image_.get(), description.name);
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device.handle(), image_.get(), &needs);
  bytes_ = needs.size;
  memory_ = allocate(device, needs, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, false, description.name);
  check(vkBindImageMemory(device.handle(), image_.get(), memory_.get(), 0), "vkBindImageMemory");
  VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view.image = image_.get();
  view.viewType = description.layers > 1 || description.array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
  view.format = description.format;
  view.subresourceRange = {aspect(), 0, description.mips, 0, description.layers};
  check(vkCreateImageView(device.handle(), &view, nullptr, view_.made_by(device.handle())), "vkCreateImageView");
  device.name(VK_OBJECT_TYPE_IMAGE_VIEW, view_.get(), description.name);
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  for (std::uint32_t layer = 0; layer < description.layers; ++layer) {
    view.subresourceRange = {aspect(), 0, 1, layer, 1};
    UniqueImageView& one = layer_views_.emplace_back();
    check(vkCreateImageView(device.handle(), &view, nullptr, one.made_by(device.handle())), "vkCreateImageView");
    device.name(VK_OBJECT_TYPE_IMAGE_VIEW, one.get(), fmt::format("{} layer {}", description.name, layer));
  }
}

Sampler::Sampler(Device& device, const SamplerDescription& description) {
  VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  create.magFilter = description.magnify;
  create.minFilter = description.minify;
  create.mipmapMode = description.mipmap;
  create.addressModeU = create.addressModeW = description.address_u;
  create.addressModeV = description.address_v;
  create.maxLod = VK_LOD_CLAMP_NONE;
  create.borderColor = VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE;
  check(vkCreateSampler(device.handle(), &create, nullptr, sampler_.made_by(device.handle())), "vkCreateSampler");
}

std::uint32_t bytes_per_texel(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_UINT:
      return 1;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_D32_SFLOAT:
      return 4;
    case VK_FORMAT_R32G32_UINT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      return 8;
    case VK_FORMAT_R32G32B32A32_UINT:
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      return 16;
    default:
      throw std::logic_error(fmt::format("texel size of format {}", static_cast<int>(format)));
  }
}

namespace {

void transition(VkCommandBuffer commands, Image& image, AccessState next) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.srcStageMask = image.state.stages;
  barrier.srcAccessMask = image.state.access;
  barrier.dstStageMask = next.stages;
  barrier.dstAccessMask = next.access;
  barrier.oldLayout = image.state.layout;
  barrier.newLayout = next.layout;
  barrier.image = image.handle();
  barrier.subresourceRange = {image.aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
  image.state = next;
}

}  // namespace

void upload(Device& device, Image& image, std::uint32_t mip, std::uint32_t layer, std::span<const std::byte> texels) {
  const auto& description = image.description();
  const std::uint32_t width = std::max(1u, description.width >> mip), height = std::max(1u, description.height >> mip);
  const std::size_t expected = std::size_t{width} * height * bytes_per_texel(description.format);
  if (texels.size() != expected)
    throw std::logic_error(
        fmt::format("upload to {}: {} bytes given, {} expected", description.name, texels.size(), expected));
  Buffer staging(device, description.name + " upload", texels.size());
  std::memcpy(staging.mapped().data(), texels.data(), texels.size());
  device.run(staging.name(), [&](VkCommandBuffer commands) {
    transition(
        commands, image,
        {VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL});
    VkBufferImageCopy copy{};
    copy.imageSubresource = {image.aspect(), mip, layer, 1};
    copy.imageExtent = {width, height, 1};
    vkCmdCopyBufferToImage(commands, staging.handle(), image.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  });
}

std::vector<std::byte> download(Device& device, Image& image, std::uint32_t layer) {
  const auto& description = image.description();
  const std::size_t bytes = std::size_t{description.width} * description.height * bytes_per_texel(description.format);
  Buffer staging(device, description.name + " download", bytes);
  device.run(staging.name(), [&](VkCommandBuffer commands) {
    transition(commands, image,
               {VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
    VkBufferImageCopy copy{};
    copy.imageSubresource = {image.aspect(), 0, layer, 1};
    copy.imageExtent = {description.width, description.height, 1};
    vkCmdCopyImageToBuffer(commands, image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging.handle(), 1, &copy);
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_TRANSFER_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
  });
  return {staging.mapped().begin(), staging.mapped().begin() + static_cast<std::ptrdiff_t>(bytes)};
}

void copy_rows(Device& device, Image& from, std::uint32_t first, Image& to, std::uint32_t to_first,
               std::uint32_t rows) {
  device.run(from.description().name + " rows", [&](VkCommandBuffer commands) {
    transition(commands, from,
               {VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
    transition(
        commands, to,
        {VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL});
    VkImageCopy copy{};
    copy.srcSubresource = {from.aspect(), 0, 0, 1};
    copy.srcOffset = {0, static_cast<std::int32_t>(first), 0};
    copy.dstSubresource = {to.aspect(), 0, 0, 1};
    copy.dstOffset = {0, static_cast<std::int32_t>(to_first), 0};
    copy.extent = {from.description().width, rows, 1};
    vkCmdCopyImage(commands, from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(),
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  });
}

}  // namespace subpixel::gpu
