#include "replay/gpu/pipeline.hpp"

#include <thread>

#include "shaders/embedded.hpp"

namespace subpixel::gpu {
namespace {

struct Specialization {
  std::vector<VkSpecializationMapEntry> entries;
  std::vector<std::uint32_t> values;
  VkSpecializationInfo info{};
  explicit Specialization(const Constants& constants) {
    for (const auto& [id, value] : constants) {
      entries.push_back({id, static_cast<std::uint32_t>(values.size() * sizeof(std::uint32_t)), sizeof(std::uint32_t)});
      values.push_back(value);
    }
    info = {static_cast<std::uint32_t>(entries.size()), entries.data(), values.size() * sizeof(std::uint32_t),
            values.data()};
  }
  Specialization(const Specialization&) = delete;
  Specialization& operator=(const Specialization&) = delete;
};

VkDescriptorType binding_type(std::uint32_t binding) {
  if (binding == kUniformBinding) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  if (binding < kSampledBinding) return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  if (binding < kStorageImageBinding) return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  if (binding < kInputAttachmentBinding) return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  return VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT;
}

}  // namespace

PipelineCache::PipelineCache(Device& device)
    : device_(device), threads_(std::max(1u, std::thread::hardware_concurrency())) {
  std::vector<VkDescriptorSetLayoutBinding> bindings(kBindings);
  for (std::uint32_t i = 0; i < kBindings; ++i) {
    const VkDescriptorType type = binding_type(i);
    const VkShaderStageFlags stages =
        type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT ? VK_SHADER_STAGE_FRAGMENT_BIT : VK_SHADER_STAGE_ALL;
    bindings[i] = {i, type, 1, stages, nullptr};
  }
  VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  layout.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
  layout.bindingCount = kBindings;
  layout.pBindings = bindings.data();
  check(vkCreateDescriptorSetLayout(device.handle(), &layout, nullptr, push_layout_.made_by(device.handle())),
        "vkCreateDescriptorSetLayout");

  std::vector<VkDescriptorSetLayoutBinding> textures(kMaterialTextures);
  for (std::uint32_t i = 0; i < kMaterialTextures; ++i)
    textures[i] = {i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_ALL, nullptr};
  layout.flags = 0;
  layout.bindingCount = kMaterialTextures;
  layout.pBindings = textures.data();
  check(vkCreateDescriptorSetLayout(device.handle(), &layout, nullptr, material_layout_.made_by(device.handle())),
        "vkCreateDescriptorSetLayout");

  const VkDescriptorSetLayout sets[] = {push_layout_.get(), material_layout_.get()};
  const VkPushConstantRange range{VK_SHADER_STAGE_ALL, 0, kPushConstantBytes};
  VkPipelineLayoutCreateInfo create{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  create.setLayoutCount = 2;
  create.pSetLayouts = sets;
  create.pushConstantRangeCount = 1;
  create.pPushConstantRanges = &range;
  check(vkCreatePipelineLayout(device.handle(), &create, nullptr, layout_.made_by(device.handle())),
        "vkCreatePipelineLayout");
}

const ShaderInterface& PipelineCache::interface(const std::string& shader) {
  const auto known = interfaces_.find(shader);
  if (known != interfaces_.end()) return known->second;
  return interfaces_.emplace(shader, interface_of(device_.shaders().words(shader))).first->second;
}

const std::vector<std::uint32_t>& PipelineCache::folder_constants(const std::string& shader) {
  const std::string folder = shader.substr(0, shader.rfind('/') + 1);
  const auto [ids, is_new] = folder_constants_.try_emplace(folder);
  if (!is_new) return ids->second;
  for (const auto& embedded : shaders::all()) {
    if (!embedded.name.starts_with(folder)) continue;
    for (const auto& constant : interface(std::string(embedded.name)).constants) ids->second.push_back(constant.id);
  }
  return ids->second;
}

VkShaderModule PipelineCache::module(const std::string& shader) {
  auto& found = modules_[shader];
  if (found) return found.get();
  const Instance::Work work(device_.instance(), "shader", shader);
  const auto words = device_.shaders().words(shader);
  VkShaderModuleCreateInfo create{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  create.codeSize = words.size_bytes();
  create.pCode = words.data();
  check(vkCreateShaderModule(device_.handle(), &create, nullptr, found.made_by(device_.handle())), "shader " + shader);
  device_.name(VK_OBJECT_TYPE_SHADER_MODULE, found.get(), shader);
  return found.get();
}

void PipelineCache::begin(Pipeline& pipeline, const std::string& name, std::function<void(VkPipeline*)> make) {
  VkPipeline* const handle = pipeline.handle_.made_by(device_.handle());
  // What the validation layer says of one is told apart by what the host is at, which is one thing at a time.
  const bool alone = device_.instance().listens();
  const auto policy = alone ? std::launch::deferred : std::launch::async;
  pipeline.made_ = std::async(policy, [this, handle, name, make = std::move(make)] {
                     const Turns::Turn turn(threads_);
                     const Instance::Work work(device_.instance(), "pipeline", name);
                     make(handle);
                     device_.name(VK_OBJECT_TYPE_PIPELINE, *handle, name);
                   }).share();
  if (alone) pipeline.made_.get();
}

const Pipeline& PipelineCache::compute(const std::string& shader, const Constants& constants) {
  Pipeline& found = compute_[{shader, constants}];
  if (found.made_.valid()) return found;
  const VkShaderModule code = module(shader);
  begin(found, shader, [this, shader, constants, code](VkPipeline* pipeline) {
    const Specialization specialization(constants);
    VkComputePipelineCreateInfo create{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = code;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &specialization.info;
    create.layout = layout_.get();
    check(vkCreateComputePipelines(device_.handle(), VK_NULL_HANDLE, 1, &create, nullptr, pipeline),
          "pipeline " + shader);
  });
  return found;
}

VkRenderPass PipelineCache::render_pass(const RenderPassDescription& description) {
  auto& found = render_passes_[description];
  if (found) return found.get();
  const VkImageLayout colour_layout =
      description.ordered_read ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  const VkAttachmentLoadOp load = description.clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  std::vector<VkAttachmentDescription> attachments;
  std::vector<VkAttachmentReference> colours;
  for (const VkFormat format : description.colours) {
    colours.push_back({static_cast<std::uint32_t>(attachments.size()), colour_layout});
    attachments.push_back({0, format, description.samples, load, VK_ATTACHMENT_STORE_OP_STORE,
                           VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, colour_layout,
                           colour_layout});
  }
  VkAttachmentReference depth{VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  if (description.depth != VK_FORMAT_UNDEFINED) {
    depth.attachment = static_cast<std::uint32_t>(attachments.size());
    attachments.push_back({0, description.depth, description.samples, load, VK_ATTACHMENT_STORE_OP_STORE,
                           VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, depth.layout,
                           depth.layout});
  }
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = static_cast<std::uint32_t>(colours.size());
  subpass.pColorAttachments = colours.data();
  subpass.pDepthStencilAttachment = &depth;
  VkSubpassDependency self{};
  if (description.ordered_read) {
    subpass.flags = VK_SUBPASS_DESCRIPTION_RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_BIT_EXT;
    subpass.inputAttachmentCount = subpass.colorAttachmentCount;
    subpass.pInputAttachments = colours.data();
    self.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    self.dstStageMask = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
    self.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    self.dstAccessMask = VK_ACCESS_INPUT_ATTACHMENT_READ_BIT;
    self.dependencyFlags = VK_DEPENDENCY_BY_REGION_BIT;
  }
  VkRenderPassCreateInfo create{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  create.attachmentCount = static_cast<std::uint32_t>(attachments.size());
  create.pAttachments = attachments.data();
  create.subpassCount = 1;
  create.pSubpasses = &subpass;
  create.dependencyCount = description.ordered_read ? 1 : 0;
  create.pDependencies = &self;
  check(vkCreateRenderPass(device_.handle(), &create, nullptr, found.made_by(device_.handle())), "vkCreateRenderPass");
  return found.get();
}

namespace {

struct RasterModules {
  VkShaderModule vertex = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE;
};

void make_raster(VkDevice device, VkPipelineLayout layout, VkRenderPass render_pass, const RasterModules& modules,
                 const RasterDescription& description, VkPipeline* pipeline) {
  const Specialization specialization(description.constants);
  std::vector<VkPipelineShaderStageCreateInfo> stages;
  const auto add_stage = [&](VkShaderStageFlagBits stage, VkShaderModule code) {
    if (code == VK_NULL_HANDLE) return;
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = stage;
    info.module = code;
    info.pName = "main";
    info.pSpecializationInfo = &specialization.info;
    stages.push_back(info);
  };
  add_stage(VK_SHADER_STAGE_VERTEX_BIT, modules.vertex);
  add_stage(VK_SHADER_STAGE_FRAGMENT_BIT, modules.fragment);

  VkPipelineVertexInputStateCreateInfo vertex_input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = description.topology;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  rasterization.cullMode = description.cull;
  rasterization.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  rasterization.lineWidth = 1;
  rasterization.depthBiasEnable = description.depth_bias != 0 || description.depth_bias_slope != 0;
  rasterization.depthBiasConstantFactor = description.depth_bias;
  rasterization.depthBiasSlopeFactor = description.depth_bias_slope;
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = description.targets.samples;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = description.targets.depth != VK_FORMAT_UNDEFINED;
  depth.depthWriteEnable = description.depth_write;
  depth.depthCompareOp = description.depth_compare;
  VkPipelineColorBlendAttachmentState blend{};
  blend.colorWriteMask = 0xf;
  blend.blendEnable = description.additive;
  blend.srcColorBlendFactor = blend.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
  blend.srcAlphaBlendFactor = blend.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  const std::vector<VkPipelineColorBlendAttachmentState> blends(description.targets.colours.size(), blend);
  VkPipelineColorBlendStateCreateInfo blending{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  if (description.targets.ordered_read)
    blending.flags = VK_PIPELINE_COLOR_BLEND_STATE_CREATE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_BIT_EXT;
  blending.attachmentCount = static_cast<std::uint32_t>(blends.size());
  blending.pAttachments = blends.data();
  constexpr VkDynamicState kDynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = 2;
  dynamic.pDynamicStates = kDynamic;

  VkGraphicsPipelineCreateInfo create{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  create.stageCount = static_cast<std::uint32_t>(stages.size());
  create.pStages = stages.data();
  create.pVertexInputState = &vertex_input;
  create.pInputAssemblyState = &assembly;
  create.pViewportState = &viewport;
  create.pRasterizationState = &rasterization;
  create.pMultisampleState = &multisample;
  create.pDepthStencilState = &depth;
  create.pColorBlendState = &blending;
  create.pDynamicState = &dynamic;
  create.layout = layout;
  create.renderPass = render_pass;
  check(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &create, nullptr, pipeline),
        "pipeline " + description.vertex + " + " + description.fragment);
}

}  // namespace

const Pipeline& PipelineCache::raster(const RasterDescription& description) {
  Pipeline& found = raster_[description];
  if (found.made_.valid()) return found;
  const auto code = [&](const std::string& shader) {
    return shader.empty() ? VkShaderModule{VK_NULL_HANDLE} : module(shader);
  };
  const RasterModules modules{code(description.vertex), code(description.fragment)};
  const VkRenderPass pass = render_pass(description.targets);
  begin(found, description.vertex + " + " + description.fragment,
        [this, description, modules, pass](VkPipeline* pipeline) {
          make_raster(device_.handle(), layout_.get(), pass, modules, description, pipeline);
        });
  return found;
}

}  // namespace subpixel::gpu
