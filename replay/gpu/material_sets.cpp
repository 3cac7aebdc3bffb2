#include "replay/gpu/material_sets.hpp"

#include <algorithm>

namespace subpixel::gpu {
namespace {

void make_sampled(Device& device, Image& image) {
  const AccessState sampled{VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                            VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  if (image.state.layout == sampled.layout) return;
  device.run(image.description().name + " for sampling", [&](VkCommandBuffer commands) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = image.state.stages;
    barrier.srcAccessMask = image.state.access;
    barrier.dstStageMask = sampled.stages;
    barrier.dstAccessMask = sampled.access;
    barrier.oldLayout = image.state.layout;
    barrier.newLayout = sampled.layout;
    barrier.image = image.handle();
    barrier.subresourceRange = {image.aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = 1;
    dependency.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
  });
  image.state = sampled;
}

}  // namespace

MaterialSets::MaterialSets(Device& device, std::uint32_t capacity) : device_(device) {
  capacity = std::max(capacity, 1u);
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, capacity * kMaterialTextures};
  VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  create.maxSets = capacity;
  create.poolSizeCount = 1;
  create.pPoolSizes = &size;
  check(vkCreateDescriptorPool(device.handle(), &create, nullptr, pool_.made_by(device.handle())),
        "vkCreateDescriptorPool");
}

VkDescriptorSet MaterialSets::set_of(const std::array<MaterialTexture, kMaterialTextures>& textures) {
  auto& set = sets_[textures];
  if (set) return set;
  const VkDescriptorSetLayout layout = device_.pipelines().material_set_layout();
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_.get();
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &layout;
  check(vkAllocateDescriptorSets(device_.handle(), &allocate, &set), "vkAllocateDescriptorSets");
  std::array<VkDescriptorImageInfo, kMaterialTextures> infos;
  std::array<VkWriteDescriptorSet, kMaterialTextures> writes;
  for (std::uint32_t i = 0; i < kMaterialTextures; ++i) {
    make_sampled(device_, *textures[i].image);
    infos[i] = {textures[i].sampler->handle(), textures[i].image->view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    writes[i].dstSet = set;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    writes[i].pImageInfo = &infos[i];
  }
  vkUpdateDescriptorSets(device_.handle(), kMaterialTextures, writes.data(), 0, nullptr);
  return set;
}

}  // namespace subpixel::gpu
