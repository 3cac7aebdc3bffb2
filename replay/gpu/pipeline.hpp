// Pipelines by description, made once and kept, on threads of their own: drivers take long over it. The first run of a
// pipeline pays its compilation.
//
// All pipelines share one layout, whose numbers are those of shaders/include/interface.h:
//   set 0, push descriptors: uniform buffer | storage buffers | combined image samplers | storage images |
//                            input attachments
//   set 1: the textures of one material
//   push constants: 128 bytes, all stages
#pragma once

#include <future>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/turns.hpp"
#include "replay/gpu/device.hpp"
#include "replay/gpu/shader_interface.hpp"
#include "shaders/include/interface.h"

namespace subpixel::gpu {

// The first binding of each kind.
inline constexpr std::uint32_t kUniformBinding = UNIFORM_BINDING, kStorageBinding = STORAGE(0),
                               kSampledBinding = SAMPLED(0), kStorageImageBinding = STORAGE_IMAGE(0),
                               kInputAttachmentBinding = INPUT_ATTACHMENT(0), kBindings = 32;
inline constexpr std::uint32_t kPushConstantBytes = 128, kMaterialTextures = MATERIAL_SLOT_EMISSIVE + 1;

// Specialization constants: id -> 32-bit value.
using Constants = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
inline void append(Constants& constants, const Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

struct RenderPassDescription {
  std::vector<VkFormat> colours;
  VkFormat depth = VK_FORMAT_UNDEFINED;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  // Fragments read what earlier fragments of the pixel wrote, in primitive order
  // (VK_EXT_rasterization_order_attachment_access): every colour attachment is also an input attachment.
  bool ordered_read = false;
  bool clear = false;  // attachments are cleared, else loaded
  // NOLINTNEXTLINE(modernize-use-nullptr): it takes the 0 that a comparison's result is held against for a pointer
  auto operator<=>(const RenderPassDescription&) const = default;
};

struct RasterDescription {
  std::string vertex, fragment;  // shader names
  Constants constants;           // both stages
  RenderPassDescription targets;
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkCompareOp depth_compare = VK_COMPARE_OP_ALWAYS;
  bool depth_write = false;
  VkCullModeFlags cull = VK_CULL_MODE_NONE;
  bool additive = false;  // colour = source + destination, all attachments
  float depth_bias = 0, depth_bias_slope = 0;
  // NOLINTNEXTLINE(modernize-use-nullptr): as above
  auto operator<=>(const RasterDescription&) const = default;
};

// A pipeline that is made or being made.
class Pipeline {
 public:
  // Waits for it. Throws DeviceError when it could not be made.
  VkPipeline get() const {
    made_.get();
    return handle_.get();
  }
  void wait() const { made_.wait(); }

 private:
  friend class PipelineCache;
  UniquePipeline handle_;
  std::shared_future<void> made_;  // ends before what it fills
};

class PipelineCache {
 public:
  explicit PipelineCache(Device& device);
  VkPipelineLayout layout() const { return layout_.get(); }
  VkDescriptorSetLayout material_set_layout() const { return material_layout_.get(); }
  // Begin to make it unless that is done. Pipelines stay where they are as long as the cache.
  const Pipeline& compute(const std::string& shader, const Constants& constants);
  const Pipeline& raster(const RasterDescription& description);
  VkRenderPass render_pass(const RenderPassDescription& description);
  // What a shader of the build declares; walked once.
  const ShaderInterface& interface(const std::string& shader);
  // Ids of constants that any shader of the same folder declares.
  const std::vector<std::uint32_t>& folder_constants(const std::string& shader);

 private:
  VkShaderModule module(const std::string& shader);
  // `make` fills the pipeline's handle, on as many threads as the machine has.
  void begin(Pipeline& pipeline, const std::string& name, std::function<void(VkPipeline*)> make);

  Device& device_;
  Turns threads_;
  UniqueSetLayout push_layout_, material_layout_;
  UniquePipelineLayout layout_;
  std::map<std::string, UniqueShaderModule> modules_;
  std::map<std::string, ShaderInterface> interfaces_;
  std::map<std::string, std::vector<std::uint32_t>> folder_constants_;
  std::map<RenderPassDescription, UniqueRenderPass> render_passes_;
  // The last members, which end first: what is being made needs the others.
  std::map<std::pair<std::string, Constants>, Pipeline> compute_;
  std::map<RasterDescription, Pipeline> raster_;
};

}  // namespace subpixel::gpu
