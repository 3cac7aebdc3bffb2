// A capture made ready for the device: geometry and materials once, transforms, lights and shadow map for each frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/gpu/pass_recorder.hpp"
#include "shaders/include/shared_types.h"

namespace subpixel::replay {

// What the scene needs, FEATURE_ bits of shared_types.h: shaders are specialised by them.
struct SceneFeatures {
  std::uint32_t bits = 0;
  bool has(std::uint32_t feature) const { return (bits & feature) != 0; }
  std::vector<std::string> names() const;
};

// One draw call of the current frame, instances included, in submission order.
struct DrawItem {
  std::uint32_t material = 0;
  std::uint32_t first_index = 0;     // into `indices`
  std::uint32_t triangle_count = 0;  // of one instance
  std::uint32_t first_instance = 0;  // into `instances`
  std::uint32_t instance_count = 0;
};

struct SceneOptions {
  std::optional<std::uint32_t> point_lights;  // exactly this many; missing ones are placed inside the scene's bounds
  bool every_light = false;                   // points evaluate all lights, not those of their cell alone
  std::uint32_t shadow_map_size = 2048;
  // FEATURE_ bits that shaders and layouts have whether or not the scene needs them; kAllFeatures: the general case
  // that the specialised ones are compared with.
  std::uint32_t forced_features = 0;
};

inline constexpr std::uint32_t kAllFeatures = 2 * SUBPIXEL_LAST_FEATURE - 1;

class GpuScene {
 public:
  // Uploads geometry, textures (with mipmaps) and materials of all frames. Throws InputError (a texture that can't be
  // decoded: which) and DeviceError.
  GpuScene(gpu::Device& device, const capture::Capture& capture, const SceneOptions& options);
  ~GpuScene();

  // Makes frame `index` current at `width` x `height` pixels: instances, constants and the shadow map.
  void set_frame(std::uint32_t index, std::uint32_t width, std::uint32_t height);
  // Moves the current frame's image so that what lies `jitter` pixels from a pixel's centre is there; of a new frame:
  // 0.
  void set_jitter(const glm::dvec2& jitter);
  // Has passes draw `rows` rows of the image from `first` on, into targets of that height; of a new frame: all.
  void set_band(std::uint32_t first, std::uint32_t rows);

  const capture::Capture& capture() const { return capture_; }
  SceneFeatures features() const { return features_; }
  const std::vector<DrawItem>& draws() const { return draws_; }
  std::uint64_t triangle_count() const;  // of the current frame, all instances
  const gpu_types::FrameConstants& constants() const { return constants_value_; }
  VkDescriptorSet material_set(
      std::uint32_t material) const;  // set 1: the material's textures, white where it has none
  bool alpha_tested(std::uint32_t material) const;
  bool two_sided(std::uint32_t material) const;
  bool second_uv_of_base(std::uint32_t material) const;  // its base colour's texture is placed by the second uvs
  bool has_textures(std::uint32_t material) const;  // any texture: its draws can't share a bind with another material's
  std::uint64_t bytes() const;                      // geometry, textures, shadow map

  gpu::Buffer positions;        // 3 floats a vertex, object space
  gpu::Buffer normals;          // 3 floats a vertex, unit
  gpu::Buffer uvs;              // 2 floats a vertex; empty without textures
  gpu::Buffer tangents;         // 4 floats a vertex; empty without normal maps
  gpu::Buffer second_uvs;       // 2 floats a vertex; empty where no texture is placed by them
  gpu::Buffer colours;          // 4 floats a vertex, linear; empty where no draw has them
  gpu::Buffer indices;          // 32-bit, absolute vertex numbers
  gpu::Buffer instances;        // InstanceRecord
  gpu::Buffer materials;        // MaterialRecord
  gpu::Buffer uv_mappings;      // UvMappingRecord, four a material; empty where all textures are read as they lie
  gpu::Buffer spot_cones;       // SpotConeConstants, one for each point light; empty where none has a cone
  gpu::Buffer light_cells;      // words of LightCells; empty without point lights
  gpu::Buffer frame_constants;  // FrameConstants
  gpu::Image shadow_map;        // 1x1 without shadows
  gpu::Sampler shadow_sampler;

 private:
  struct Impl;
  gpu::Device& device_;
  const capture::Capture& capture_;
  SceneFeatures features_;
  std::vector<DrawItem> draws_;
  gpu_types::FrameConstants constants_value_{};
  std::unique_ptr<Impl> impl_;
};

}  // namespace subpixel::replay
