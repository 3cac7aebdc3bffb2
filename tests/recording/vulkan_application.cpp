// The test scene by Vulkan 1.3 in a window: the scene into targets of its own, a post pass and a HUD to the swapchain.
// Ends by itself after the number of frames that it is given.
#define VK_USE_PLATFORM_XLIB_KHR
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "scene.hpp"
#include "vulkan_shaders.hpp"

namespace {

void check(VkResult result, const char* what) {
  if (result == VK_SUCCESS || result == VK_SUBOPTIMAL_KHR) return;
  std::fprintf(stderr, "vulkan_application: %s: %d\n", what, result);
  std::exit(1);
}

constexpr VkFormat kColour = VK_FORMAT_R8G8B8A8_UNORM, kDepth = VK_FORMAT_D32_SFLOAT;
constexpr VkExtent2D kExtent{scene::kWidth, scene::kHeight};

struct Constants {
  scene::Matrix model;
  float settings[4];
};

struct Buffer {
  VkBuffer handle{};
  std::byte* memory = nullptr;
};

struct Image {
  VkImage handle{};
  VkImageView view{};
};

// Everything lives until the process ends.
class Application {
 public:
  Application() {
    make_device();
    make_swapchain();
    make_resources();
    opaque_ = scene_pipeline(Kind::opaque, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST);
    strip_ = scene_pipeline(Kind::opaque, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP);
    fan_ = scene_pipeline(Kind::opaque, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN);
    two_sided_ = scene_pipeline(Kind::two_sided, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST);
    blended_ = scene_pipeline(Kind::blended, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST);
    screen_ = pipeline({kScreenVertex, kScreenFragment, swapchain_format_, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST});
  }

  void draw_frame(float time) {
    const scene::Scene made = scene::make_scene(time);
    const scene::Camera camera = scene::make_camera(time, true);
    const auto fill = [](const Buffer& buffer, const auto& values) {
      std::memcpy(buffer.memory, values.data(), values.size() * sizeof values[0]);
    };
    fill(vertices_, made.vertices);
    fill(indices_, made.indices);
    fill(instances_, made.instances);
    std::memcpy(camera_.memory, &camera, sizeof camera);
    std::uint32_t number = 0;
    check(vkAcquireNextImageKHR(device_, swapchain_, UINT64_MAX, VK_NULL_HANDLE, fence_, &number), "acquire");
    wait();
    begin();
    transition(target_.handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
               VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    transition(depth_.handle, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
               VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    begin_rendering(target_.view, depth_.view);
    for (const scene::Part& part : made.parts) {
      bind(part.decal ? decal_set_ : scene_set_);
      draw(part);
    }
    vkCmdEndRendering(commands_);
    transition(target_.handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
               VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    transition(swapchain_images_[number].handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
               VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    begin_rendering(swapchain_images_[number].view, VK_NULL_HANDLE);
    bind(screen_set_);
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, screen_);
    vkCmdDraw(commands_, 3, 1, 0, 0);
    const VkViewport corner{8, 8, 40, 20, 0, 1};
    vkCmdSetViewport(commands_, 0, 1, &corner);
    vkCmdDraw(commands_, 3, 1, 0, 0);
    vkCmdEndRendering(commands_);
    transition(swapchain_images_[number].handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
               VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    submit();
    VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    present.swapchainCount = 1, present.pSwapchains = &swapchain_, present.pImageIndices = &number;
    check(vkQueuePresentKHR(queue_, &present), "present");
  }

 private:
  enum class Kind { opaque, two_sided, blended };

  void make_device() {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_3;
    const char* const instance_extensions[] = {"VK_KHR_surface", "VK_KHR_xlib_surface"};
    VkInstanceCreateInfo instance_info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    instance_info.pApplicationInfo = &application;
    instance_info.enabledExtensionCount = 2, instance_info.ppEnabledExtensionNames = instance_extensions;
    check(vkCreateInstance(&instance_info, nullptr, &instance_), "instance");
    std::uint32_t count = 1;
    const VkResult found = vkEnumeratePhysicalDevices(instance_, &count, &physical_);
    if (count == 0) check(found == VK_SUCCESS ? VK_ERROR_INITIALIZATION_FAILED : found, "no device");
    const float priority = 1;
    VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue_info.queueCount = 1, queue_info.pQueuePriorities = &priority;
    VkPhysicalDeviceVulkan13Features features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    features.dynamicRendering = VK_TRUE, features.synchronization2 = VK_TRUE;
    const char* const device_extensions[] = {"VK_KHR_swapchain"};
    VkDeviceCreateInfo device_info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    device_info.queueCreateInfoCount = 1, device_info.pQueueCreateInfos = &queue_info;
    device_info.enabledExtensionCount = 1, device_info.ppEnabledExtensionNames = device_extensions;
    check(vkCreateDevice(physical_, &device_info, nullptr, &device_), "device");
    vkGetDeviceQueue(device_, 0, 0, &queue_);
    VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    VkCommandPool pool{};
    check(vkCreateCommandPool(device_, &pool_info, nullptr, &pool), "pool");
    VkCommandBufferAllocateInfo commands_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                              VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    check(vkAllocateCommandBuffers(device_, &commands_info, &commands_), "commands");
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vkCreateFence(device_, &fence_info, nullptr, &fence_), "fence");
  }

  void make_swapchain() {
    Display* const display = XOpenDisplay(nullptr);
    if (display == nullptr) check(VK_ERROR_INITIALIZATION_FAILED, "no display");
    const Window window =
        XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, kExtent.width, kExtent.height, 0, 0, 0);
    XMapWindow(display, window);
    XSync(display, False);
    VkXlibSurfaceCreateInfoKHR surface_info{VK_STRUCTURE_TYPE_XLIB_SURFACE_CREATE_INFO_KHR};
    surface_info.dpy = display, surface_info.window = window;
    VkSurfaceKHR surface{};
    check(vkCreateXlibSurfaceKHR(instance_, &surface_info, nullptr, &surface), "surface");
    VkBool32 supported = VK_FALSE;
    check(vkGetPhysicalDeviceSurfaceSupportKHR(physical_, 0, surface, &supported), "surface");
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface, info.minImageCount = 3, info.imageFormat = swapchain_format_, info.imageExtent = kExtent;
    info.imageArrayLayers = 1, info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    info.preTransform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR, info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
    check(vkCreateSwapchainKHR(device_, &info, nullptr, &swapchain_), "swapchain");
    std::uint32_t count = 0;
    vkGetSwapchainImagesKHR(device_, swapchain_, &count, nullptr);
    std::vector<VkImage> images(count);
    vkGetSwapchainImagesKHR(device_, swapchain_, &count, images.data());
    for (const VkImage image : images) {
      swapchain_images_.push_back({image, view_of(image, swapchain_format_, VK_IMAGE_ASPECT_COLOR_BIT)});
    }
  }

  void make_resources() {
    vertices_ = buffer(1 << 18, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = buffer(1 << 16, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    instances_ = buffer(1 << 12, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    camera_ = buffer(sizeof(scene::Camera), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    target_ = image(kExtent, kColour, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    depth_ = image(kExtent, kDepth, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    const Image texture = make_texture(scene::make_texture()), decal = make_texture(scene::make_decal_texture());
    VkDescriptorSetLayoutBinding bindings[2] = {
        {0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr},
        {2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}};
    VkDescriptorSetLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    layout_info.bindingCount = 2, layout_info.pBindings = bindings;
    VkDescriptorSetLayout set_layout{};
    check(vkCreateDescriptorSetLayout(device_, &layout_info, nullptr, &set_layout), "set layout");
    const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(Constants)};
    VkPipelineLayoutCreateInfo pipeline_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    pipeline_info.setLayoutCount = 1, pipeline_info.pSetLayouts = &set_layout;
    pipeline_info.pushConstantRangeCount = 1, pipeline_info.pPushConstantRanges = &range;
    check(vkCreatePipelineLayout(device_, &pipeline_info, nullptr, &layout_), "pipeline layout");
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 3},
                                          {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 3}};
    VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool_info.maxSets = 3, pool_info.poolSizeCount = 2, pool_info.pPoolSizes = sizes;
    VkDescriptorPool pool{};
    check(vkCreateDescriptorPool(device_, &pool_info, nullptr, &pool), "descriptor pool");
    VkSamplerCreateInfo sampler_info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler_info.magFilter = sampler_info.minFilter = VK_FILTER_LINEAR;
    VkSampler sampler{};
    check(vkCreateSampler(device_, &sampler_info, nullptr, &sampler), "sampler");
    const auto make_set = [&](VkDescriptorSet& set, VkImageView view) {
      const VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1,
                                             &set_layout};
      check(vkAllocateDescriptorSets(device_, &info, &set), "descriptor set");
      const VkDescriptorBufferInfo constants{camera_.handle, 0, VK_WHOLE_SIZE};
      const VkDescriptorImageInfo sampled{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      VkWriteDescriptorSet writes[2]{{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET},
                                     {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}};
      for (int i = 0; i < 2; ++i) {
        writes[i].dstSet = set, writes[i].dstBinding = bindings[i].binding, writes[i].descriptorCount = 1;
        writes[i].descriptorType = bindings[i].descriptorType;
      }
      writes[0].pBufferInfo = &constants, writes[1].pImageInfo = &sampled;
      vkUpdateDescriptorSets(device_, 2, writes, 0, nullptr);
    };
    make_set(scene_set_, texture.view);
    make_set(decal_set_, decal.view);
    make_set(screen_set_, target_.view);
  }

  Image make_texture(const std::vector<std::uint8_t>& texels) {
    const VkExtent2D side{scene::kTextureSide, scene::kTextureSide};
    const Image out =
        image(side, VK_FORMAT_R8G8B8A8_SRGB, VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    const Buffer staging = buffer(texels.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    std::memcpy(staging.memory, texels.data(), texels.size());
    begin();
    transition(out.handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {side.width, side.height, 1};
    vkCmdCopyBufferToImage(commands_, staging.handle, out.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(out.handle, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    submit();
    return out;
  }

  VkDeviceMemory memory(const VkMemoryRequirements& needs) {
    VkPhysicalDeviceMemoryProperties properties;
    vkGetPhysicalDeviceMemoryProperties(physical_, &properties);
    // Of a CPU's driver every type can be seen; the first that will do is as good as any.
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, 0};
    for (std::uint32_t i = properties.memoryTypeCount; i-- > 0;) {
      const bool visible = (properties.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) != 0;
      if (visible && (needs.memoryTypeBits >> i & 1) != 0) info.memoryTypeIndex = i;
    }
    VkDeviceMemory out{};
    check(vkAllocateMemory(device_, &info, nullptr, &out), "memory");
    return out;
  }

  Buffer buffer(VkDeviceSize size, VkBufferUsageFlags usage) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size, info.usage = usage;
    Buffer out;
    check(vkCreateBuffer(device_, &info, nullptr, &out.handle), "buffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device_, out.handle, &needs);
    const VkDeviceMemory held = memory(needs);
    check(vkBindBufferMemory(device_, out.handle, held, 0), "buffer memory");
    void* mapped = nullptr;
    check(vkMapMemory(device_, held, 0, VK_WHOLE_SIZE, 0, &mapped), "map");
    out.memory = static_cast<std::byte*>(mapped);
    return out;
  }

  VkImageView view_of(VkImage image, VkFormat format, VkImageAspectFlags aspect) {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image, info.viewType = VK_IMAGE_VIEW_TYPE_2D, info.format = format;
    info.subresourceRange = {aspect, 0, 1, 0, 1};
    VkImageView out{};
    check(vkCreateImageView(device_, &info, nullptr, &out), "image view");
    return out;
  }

  Image image(VkExtent2D extent, VkFormat format, VkImageUsageFlags usage) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D, info.format = format, info.extent = {extent.width, extent.height, 1};
    info.mipLevels = info.arrayLayers = 1, info.samples = VK_SAMPLE_COUNT_1_BIT, info.usage = usage;
    Image out;
    check(vkCreateImage(device_, &info, nullptr, &out.handle), "image");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device_, out.handle, &needs);
    check(vkBindImageMemory(device_, out.handle, memory(needs), 0), "image memory");
    out.view = view_of(out.handle, format, format == kDepth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT);
    return out;
  }

  struct PipelineDescription {
    std::span<const std::uint32_t> vertex, fragment;
    VkFormat colour;
    VkPrimitiveTopology topology;
    bool is_scene = false, two_sided = false, blends = false;
  };

  VkPipeline scene_pipeline(Kind kind, VkPrimitiveTopology topology) {
    return pipeline(
        {kSceneVertex, kSceneFragment, kColour, topology, true, kind == Kind::two_sided, kind == Kind::blended});
  }

  VkPipeline pipeline(const PipelineDescription& wanted) {
    const auto stage = [&](VkShaderStageFlagBits bit, std::span<const std::uint32_t> code) {
      const VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, nullptr, 0, code.size_bytes(),
                                          code.data()};
      VkShaderModule shader{};
      check(vkCreateShaderModule(device_, &info, nullptr, &shader), "shader");
      return VkPipelineShaderStageCreateInfo{
          VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, bit, shader, "main", nullptr};
    };
    const VkPipelineShaderStageCreateInfo stages[] = {stage(VK_SHADER_STAGE_VERTEX_BIT, wanted.vertex),
                                                      stage(VK_SHADER_STAGE_FRAGMENT_BIT, wanted.fragment)};
    const VkVertexInputBindingDescription bindings[] = {{0, sizeof(scene::Vertex), VK_VERTEX_INPUT_RATE_VERTEX},
                                                        {1, 12, VK_VERTEX_INPUT_RATE_INSTANCE}};
    const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                            {1, 0, VK_FORMAT_R32G32B32_SFLOAT, 12},
                                                            {2, 0, VK_FORMAT_R32G32_SFLOAT, 24},
                                                            {3, 0, VK_FORMAT_R32_SFLOAT, 32},
                                                            {4, 1, VK_FORMAT_R32G32B32_SFLOAT, 0}};
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    if (wanted.is_scene) {
      input.vertexBindingDescriptionCount = 2, input.pVertexBindingDescriptions = bindings;
      input.vertexAttributeDescriptionCount = 5, input.pVertexAttributeDescriptions = attributes;
    }
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = wanted.topology;
    assembly.primitiveRestartEnable = wanted.topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP ? VK_TRUE : VK_FALSE;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.cullMode = wanted.is_scene && !wanted.two_sided ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE, raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = wanted.is_scene, depth.depthWriteEnable = wanted.is_scene && !wanted.blends;
    depth.depthCompareOp = wanted.blends ? VK_COMPARE_OP_LESS_OR_EQUAL : VK_COMPARE_OP_LESS;
    VkPipelineColorBlendAttachmentState blend{};
    blend.blendEnable = wanted.blends, blend.colorWriteMask = 15;
    blend.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA,
    blend.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    VkPipelineColorBlendStateCreateInfo blends{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blends.attachmentCount = 1, blends.pAttachments = &blend;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2, dynamic.pDynamicStates = states;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = 1, rendering.pColorAttachmentFormats = &wanted.colour;
    rendering.depthAttachmentFormat = wanted.is_scene ? kDepth : VK_FORMAT_UNDEFINED;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = 2, info.pStages = stages, info.pVertexInputState = &input, info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport, info.pRasterizationState = &raster, info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth, info.pColorBlendState = &blends, info.pDynamicState = &dynamic;
    info.layout = layout_;
    VkPipeline out{};
    check(vkCreateGraphicsPipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &out), "pipeline");
    return out;
  }

  void begin() {
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands_, &info), "begin");
  }

  void submit() {
    check(vkEndCommandBuffer(commands_), "end");
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1, info.pCommandBuffers = &commands_;
    check(vkQueueSubmit(queue_, 1, &info, fence_), "submit");
    wait();
  }

  void wait() {
    check(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "wait");
    check(vkResetFences(device_, 1, &fence_), "reset");
  }

  void transition(VkImage image, VkImageAspectFlags aspect, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.srcAccessMask = barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from, barrier.newLayout = to, barrier.image = image;
    barrier.subresourceRange = {aspect, 0, 1, 0, 1};
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                         nullptr, 0, nullptr, 1, &barrier);
  }

  void begin_rendering(VkImageView colour, VkImageView depth) {
    VkRenderingAttachmentInfo attachments[2]{{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO},
                                             {VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO}};
    for (VkRenderingAttachmentInfo& attachment : attachments) {
      attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR, attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    }
    attachments[0].imageView = colour, attachments[0].imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    attachments[0].clearValue.color = {{0.5f, 0.6f, 0.8f, 1}};
    attachments[1].imageView = depth, attachments[1].imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    attachments[1].clearValue.depthStencil.depth = 1;
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea.extent = kExtent, info.layerCount = 1;
    info.colorAttachmentCount = 1, info.pColorAttachments = &attachments[0];
    info.pDepthAttachment = depth != VK_NULL_HANDLE ? &attachments[1] : nullptr;
    vkCmdBeginRendering(commands_, &info);
    const VkViewport viewport{0, 0, static_cast<float>(kExtent.width), static_cast<float>(kExtent.height), 0, 1};
    vkCmdSetViewport(commands_, 0, 1, &viewport);
    const VkRect2D scissor{{0, 0}, kExtent};
    vkCmdSetScissor(commands_, 0, 1, &scissor);
  }

  void bind(VkDescriptorSet set) {
    vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set, 0, nullptr);
  }

  void draw(const scene::Part& part) {
    const VkPipeline by_topology[] = {opaque_, strip_, fan_};
    vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS,
                      part.blends      ? blended_
                      : part.two_sided ? two_sided_
                                       : by_topology[static_cast<int>(part.topology)]);
    const VkBuffer buffers[] = {vertices_.handle, instances_.handle};
    const VkDeviceSize offsets[] = {0, 0};
    vkCmdBindVertexBuffers(commands_, 0, 2, buffers, offsets);
    const Constants constants{part.model, {part.discards ? 0.5f : 0, scene::opacity(part), part.skinned ? 1.0f : 0, 0}};
    vkCmdPushConstants(commands_, layout_, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                       sizeof constants, &constants);
    if (part.indexed) {
      vkCmdBindIndexBuffer(commands_, indices_.handle, 0, VK_INDEX_TYPE_UINT16);
      vkCmdDrawIndexed(commands_, part.count, part.instances, part.first, part.base_vertex, part.first_instance);
    } else {
      vkCmdDraw(commands_, part.count, part.instances, part.first, part.first_instance);
    }
  }

  static constexpr VkFormat swapchain_format_ = VK_FORMAT_B8G8R8A8_UNORM;
  VkInstance instance_{};
  VkPhysicalDevice physical_{};
  VkDevice device_{};
  VkQueue queue_{};
  VkCommandBuffer commands_{};
  VkFence fence_{};
  VkSwapchainKHR swapchain_{};
  std::vector<Image> swapchain_images_;
  Buffer vertices_, indices_, instances_, camera_;
  Image target_, depth_;
  VkPipelineLayout layout_{};
  VkDescriptorSet scene_set_{}, decal_set_{}, screen_set_{};
  VkPipeline opaque_{}, strip_{}, fan_{}, two_sided_{}, blended_{}, screen_{};
};

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 1000;
  Application application;
  for (int frame = 0; frame < frames; ++frame) application.draw_frame(static_cast<float>(frame) / 30);
  return 0;
}
