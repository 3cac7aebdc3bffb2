// The textures of materials as descriptor sets: set 1 of every pipeline.
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "replay/gpu/pipeline.hpp"
#include "replay/gpu/resources.hpp"

namespace subpixel::gpu {

class MaterialSets {
 public:
  // Room for `capacity` different sets.
  MaterialSets(Device& device, std::uint32_t capacity);
  ~MaterialSets();
  MaterialSets(const MaterialSets&) = delete;
  MaterialSets& operator=(const MaterialSets&) = delete;

  // The set with these images, in the order of the bindings; equal ones share one set. The images are only sampled
  // from here on: the first use moves them to that layout. `sampler` must be the same in all calls.
  VkDescriptorSet set_of(const std::array<Image*, kMaterialTextures>& images, const Sampler& sampler);

 private:
  Device& device_;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  std::map<std::array<Image*, kMaterialTextures>, VkDescriptorSet> sets_;
};

}  // namespace subpixel::gpu
