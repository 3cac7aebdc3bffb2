// The textures of materials as descriptor sets: set 1 of every pipeline.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>

#include "replay/gpu/pipeline.hpp"
#include "replay/gpu/resources.hpp"

namespace subpixel::gpu {

// How shaders see one texture of a material. Both must outlive the sets.
struct MaterialTexture {
  Image* image = nullptr;
  const Sampler* sampler = nullptr;
  // NOLINTNEXTLINE(modernize-use-nullptr): it takes the 0 that a comparison's result is held against for a pointer
  auto operator<=>(const MaterialTexture&) const = default;
};

class MaterialSets {
 public:
  // Room for `capacity` different sets.
  MaterialSets(Device& device, std::uint32_t capacity);

  // The set with these textures, in the order of the bindings; equal ones share one set. The images are only sampled
  // from here on: the first use moves them to that layout.
  VkDescriptorSet set_of(const std::array<MaterialTexture, kMaterialTextures>& textures);

 private:
  Device& device_;
  UniqueDescriptorPool pool_;
  std::map<std::array<MaterialTexture, kMaterialTextures>, VkDescriptorSet> sets_;
};

}  // namespace subpixel::gpu
