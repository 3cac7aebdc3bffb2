#include "replay/gpu/pass_recorder.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <span>
#include <stdexcept>

#include "base/error.hpp"

namespace subpixel::gpu {

Binding uniform(Buffer& buffer) {
  return {Binding::Kind::uniform, 0, &buffer, nullptr, nullptr};
}
Binding reads(std::uint32_t slot, Buffer& buffer) {
  return {Binding::Kind::storage_read, slot, &buffer, nullptr, nullptr};
}
Binding writes(std::uint32_t slot, Buffer& buffer) {
  return {Binding::Kind::storage_write, slot, &buffer, nullptr, nullptr};
}
Binding reads(std::uint32_t slot, AddressTable& table) {
  return {Binding::Kind::storage_read, slot, &table.buffer(), nullptr, nullptr, &table};
}
Binding writes(std::uint32_t slot, AddressTable& table) {
  return {Binding::Kind::storage_write, slot, &table.buffer(), nullptr, nullptr, &table};
}
Binding samples(std::uint32_t slot, Image& image, const Sampler* sampler) {
  return {Binding::Kind::sampled, slot, nullptr, &image, sampler};
}
Binding image_writes(std::uint32_t slot, Image& image) {
  return {Binding::Kind::image_write, slot, nullptr, &image, nullptr};
}

PassRecorder::PassRecorder(Device& device) : device_(device), nearest_(device, kNearestClamped) {}
PassRecorder::~PassRecorder() {
  for (const Pipeline* pipeline : pipelines_) pipeline->wait();
  device_.ledger().release(held_);
}

void PassRecorder::hold(const std::string& name, std::uint64_t bytes) {
  device_.ledger().hold(name, bytes);
  held_ += bytes;
}

Buffer& PassRecorder::buffer(std::string name, VkDeviceSize bytes) {
  Buffer made(device_, std::move(name), bytes);  // which knows what it takes
  hold(made.name(), made.bytes());
  return buffers_.emplace_back(std::move(made));
}
Image& PassRecorder::image(const ImageDescription& description) {
  Image made(device_, description);
  hold(description.name, made.bytes());
  return images_.emplace_back(std::move(made));
}

AddressTable& PassRecorder::address_table(std::string name, VkDeviceSize bytes) {
  AddressTable made(device_, std::move(name), bytes);
  hold(made.buffer().name(), made.bytes());
  return tables_.emplace_back(std::move(made));
}

std::uint64_t PassRecorder::allocated_bytes() const {
  std::uint64_t total = 0;
  for (const auto& table : tables_) total += table.bytes();
  for (const auto& buffer : buffers_) total += buffer.bytes();
  for (const auto& image : images_) total += image.bytes();
  return total;
}

std::size_t PassRecorder::timing(const std::string& name) {
  for (std::size_t i = 0; i < timings_.size(); ++i)
    if (timings_[i].name == name) return i;
  timings_.push_back({name, {}, 0, 0, 0});
  return timings_.size() - 1;
}

std::vector<PassRecorder::Use> PassRecorder::uses_of(const std::vector<Binding>& bindings,
                                                     VkPipelineStageFlags2 stages) const {
  std::vector<Use> uses;
  for (const auto& binding : bindings) {
    Use use{
        binding.buffer, binding.image, {stages, VK_ACCESS_2_SHADER_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}};
    switch (binding.kind) {
      case Binding::Kind::uniform:
        use.state.access = VK_ACCESS_2_UNIFORM_READ_BIT;
        break;
      case Binding::Kind::storage_read:
      case Binding::Kind::sampled:
        break;
      case Binding::Kind::storage_write:
        use.state.access |= VK_ACCESS_2_SHADER_WRITE_BIT;
        break;
      case Binding::Kind::image_write:
        use.state.layout = VK_IMAGE_LAYOUT_GENERAL;
        use.state.access |= VK_ACCESS_2_SHADER_WRITE_BIT;
        break;
    }
    uses.push_back(use);
    if (binding.table == nullptr) continue;
    for (Buffer* target : binding.table->targets()) uses.push_back({target, nullptr, use.state});
  }
  return uses;
}

void PassRecorder::add_addressed(std::vector<Use>& uses, const AddressUses& addresses, VkPipelineStageFlags2 stages) {
  for (const AddressedUse& use : addresses.addressed) {
    const VkAccessFlags2 written = use.is_written ? VK_ACCESS_2_SHADER_WRITE_BIT : 0;
    uses.push_back({use.buffer, nullptr, {stages, VK_ACCESS_2_SHADER_READ_BIT | written, VK_IMAGE_LAYOUT_UNDEFINED}});
  }
}

void PassRecorder::barrier(VkCommandBuffer commands, const std::vector<Use>& uses) {
  // One memory barrier carries all buffers: their dependencies differ only in stages, which a CPU device ignores and
  // others merge. Images need their own for the layout.
  VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  std::vector<VkImageMemoryBarrier2> images;
  for (const auto& use : uses) {
    AccessState& last = use.buffer ? use.buffer->state : use.image->state;
    if (use.buffer) {
      memory.srcStageMask |= last.stages;
      memory.srcAccessMask |= last.access;
      memory.dstStageMask |= use.state.stages;
      memory.dstAccessMask |= use.state.access;
    } else {
      VkImageMemoryBarrier2 image{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
      image.srcStageMask = last.stages;
      image.srcAccessMask = last.access;
      image.dstStageMask = use.state.stages;
      image.dstAccessMask = use.state.access;
      image.oldLayout = last.layout;
      image.newLayout = use.state.layout;
      image.image = use.image->handle();
      image.subresourceRange = {use.image->aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
      images.push_back(image);
    }
    last = use.state;
  }
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  dependency.imageMemoryBarrierCount = static_cast<std::uint32_t>(images.size());
  dependency.pImageMemoryBarriers = images.data();
  vkCmdPipelineBarrier2(commands, &dependency);
}

void PassRecorder::bind(VkCommandBuffer commands, VkPipelineBindPoint point, const std::vector<Binding>& bindings,
                        const std::vector<Attachment>& inputs) {
  const std::size_t count = bindings.size() + inputs.size();
  if (count == 0) return;
  std::vector<VkDescriptorBufferInfo> buffers(count);
  std::vector<VkDescriptorImageInfo> images(count);
  std::vector<VkWriteDescriptorSet> descriptors(count);
  for (std::size_t i = 0; i < count; ++i) {
    auto& write = descriptors[i];
    write = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.descriptorCount = 1;
    write.pBufferInfo = &buffers[i];
    write.pImageInfo = &images[i];
    if (i >= bindings.size()) {
      const std::size_t input = i - bindings.size();
      write.dstBinding = static_cast<std::uint32_t>(kInputAttachmentBinding + input);
      write.descriptorType = VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT;
      images[i] = {VK_NULL_HANDLE, inputs[input].image->layer_view(inputs[input].layer), VK_IMAGE_LAYOUT_GENERAL};
      continue;
    }
    const auto& binding = bindings[i];
    // A range over the device's limit is bound up to it; passes that need more read by address.
    if (binding.buffer)
      buffers[i] = {binding.buffer->handle(), 0,
                    std::min(binding.buffer->bytes(), device_.info().max_storage_buffer_range)};
    switch (binding.kind) {
      case Binding::Kind::uniform:
        write.dstBinding = kUniformBinding;
        write.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        break;
      case Binding::Kind::storage_read:
      case Binding::Kind::storage_write:
        write.dstBinding = kStorageBinding + binding.slot;
        write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        break;
      case Binding::Kind::sampled:
        write.dstBinding = kSampledBinding + binding.slot;
        write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        images[i] = {binding.sampler ? binding.sampler->handle() : nearest_.handle(), binding.image->view(),
                     VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
        break;
      case Binding::Kind::image_write:
        write.dstBinding = kStorageImageBinding + binding.slot;
        write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        images[i] = {VK_NULL_HANDLE, binding.image->view(), VK_IMAGE_LAYOUT_GENERAL};
        break;
    }
  }
  device_.push_descriptor_set(commands, point, device_.pipelines().layout(), 0, static_cast<std::uint32_t>(count),
                              descriptors.data());
}

namespace {

std::uint32_t binding_of(const Binding& binding) {
  switch (binding.kind) {
    case Binding::Kind::uniform:
      return kUniformBinding;
    case Binding::Kind::storage_read:
    case Binding::Kind::storage_write:
      return kStorageBinding + binding.slot;
    case Binding::Kind::sampled:
      return kSampledBinding + binding.slot;
    case Binding::Kind::image_write:
      return kStorageImageBinding + binding.slot;
  }
  return 0;
}

}  // namespace

// Mistakes of ours, so a logic_error; of shaders that a folder brings, bad input.
void PassRecorder::require_interface(const std::string& pass, const std::vector<std::string>& shaders,
                                     SuppliedInterface supplied, const Constants& constants,
                                     const std::vector<Binding>& bindings, const PushConstants& push,
                                     const std::vector<Use>& uses) {
  std::vector<ShaderStage> stages;
  for (const std::string& shader : shaders) {
    if (shader.empty()) continue;
    stages.push_back({shader, &device_.pipelines().interface(shader)});
    const auto& known = device_.pipelines().folder_constants(shader);
    supplied.known_constants.insert(supplied.known_constants.end(), known.begin(), known.end());
  }
  for (const auto& [id, value] : constants) supplied.constants.push_back(id);
  for (const Binding& binding : bindings) {
    supplied.bindings.push_back(binding_of(binding));
    if (binding.table != nullptr) supplied.address_tables.push_back(binding_of(binding));
  }
  std::string wrong = mismatch(stages, supplied);
  for (const ShaderStage& stage : stages)
    if (wrong.empty()) wrong = undeclared_address(stage, push, uses);
  if (wrong.empty()) return;
  if (!device_.shaders().embedded()) throw InputError("shaders", wrong, "pass " + pass);
  throw std::logic_error(fmt::format("pass {}: {}", pass, wrong));
}

// Of the addresses that a shader declares among its push constants, the first that leads to no buffer the pass uses.
std::string PassRecorder::undeclared_address(const ShaderStage& stage, const PushConstants& push,
                                             const std::vector<Use>& uses) const {
  for (const ShaderInterface::PushAddress& member : stage.interface->push_addresses) {
    VkDeviceAddress address = 0;
    if (member.offset + sizeof address > push.size) continue;
    std::memcpy(&address, push.bytes.data() + member.offset, sizeof address);
    const auto buffer = address == 0 ? std::nullopt : device_.buffer_at(address);
    const bool is_used = buffer && std::any_of(uses.begin(), uses.end(), [&](const Use& use) {
                           return use.buffer != nullptr && use.buffer->address() == buffer->address;
                         });
    if (address == 0 || is_used) continue;
    return fmt::format("{} reads at the address {} of its push constants, and the pass does not declare {}", stage.name,
                       member.name, buffer ? "that it uses the buffer " + buffer->name : "a buffer there");
  }
  return "";
}

void PassRecorder::compute(ComputePass pass) {
  SuppliedInterface supplied;
  supplied.push_bytes = pass.push.size;
  supplied.material = pass.material != VK_NULL_HANDLE;
  Step step;
  step.timing = timing(pass.name);
  step.uses = uses_of(pass.bindings, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
  add_addressed(step.uses, pass, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
  timings_[step.timing].listed_fragments += pass.fragments;
  if (pass.indirect)
    step.uses.push_back(
        {pass.indirect,
         nullptr,
         {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED}});
  require_interface(pass.name, {pass.shader}, std::move(supplied), pass.constants, pass.bindings, pass.push, step.uses);
  const Pipeline& pipeline = device_.pipelines().compute(pass.shader, pass.constants);
  pipelines_.push_back(&pipeline);
  step.record = [this, &pipeline, pass = std::move(pass)](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.bindings, {});
    if (pass.material)
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.pipelines().layout(), 1, 1,
                              &pass.material, 0, nullptr);
    vkCmdPushConstants(commands, device_.pipelines().layout(), VK_SHADER_STAGE_ALL, 0, kPushConstantBytes,
                       pass.push.bytes.data());
    if (pass.indirect)
      vkCmdDispatchIndirect(commands, pass.indirect->handle(), 0);
    else if (pass.groups[0] > 0 && pass.groups[1] > 0 && pass.groups[2] > 0)
      vkCmdDispatch(commands, pass.groups[0], pass.groups[1], pass.groups[2]);
  };
  steps_.push_back(std::move(step));
}

namespace {

VkExtent2D extent_of(const RasterPass& pass) {
  const Image* const first = pass.colours.empty() ? pass.depth : pass.colours.front().image;
  if (!first) return {pass.size[0], pass.size[1]};
  return {first->description().width, first->description().height};
}

}  // namespace

VkFramebuffer PassRecorder::framebuffer(const RasterPass& pass, VkRenderPass render_pass) {
  std::vector<VkImageView> views;
  for (const auto& colour : pass.colours) views.push_back(colour.image->layer_view(colour.layer));
  if (pass.depth) views.push_back(pass.depth->layer_view(0));
  const VkExtent2D size = extent_of(pass);
  VkFramebufferCreateInfo create{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  create.renderPass = render_pass;
  create.attachmentCount = static_cast<std::uint32_t>(views.size());
  create.pAttachments = views.data();
  create.width = size.width;
  create.height = size.height;
  create.layers = 1;
  UniqueFramebuffer& made = framebuffers_.emplace_back();
  check(vkCreateFramebuffer(device_.handle(), &create, nullptr, made.made_by(device_.handle())), "vkCreateFramebuffer");
  device_.name(VK_OBJECT_TYPE_FRAMEBUFFER, made.get(), pass.name);
  return made.get();
}

namespace {

// Does it write to buffers or to images that are no attachments?
bool stores(const RasterPass& pass) {
  return std::ranges::any_of(pass.addressed, &AddressedUse::is_written) ||
         std::ranges::any_of(pass.bindings, [](const Binding& binding) {
           return binding.kind == Binding::Kind::storage_write || binding.kind == Binding::Kind::image_write;
         });
}

void require_parts(const DeviceInfo& info, const RasterPass& pass) {
  const char* missing = nullptr;
  if (pass.pipeline.targets.ordered_read && !info.ordered_attachments) missing = kOrderedAttachments;
  if (stores(pass) && !info.fragment_stores) missing = kFragmentStores;
  if (pass.colours.size() > 4 && !info.eight_attachments) missing = kEightAttachments;
  if (missing == nullptr) return;
  throw DeviceError("device", fmt::format("{} has no {}, which the pass needs", info.device, missing),
                    "pass " + pass.name);
}

}  // namespace

void PassRecorder::raster(RasterPass pass) {
  require_parts(device_.info(), pass);
  const bool ordered = pass.pipeline.targets.ordered_read;
  SuppliedInterface supplied;
  supplied.push_bytes = pass.push.size;
  supplied.material = static_cast<bool>(pass.draws);  // bound between the draws
  for (std::size_t i = 0; ordered && i < pass.colours.size(); ++i)
    supplied.bindings.push_back(kInputAttachmentBinding + static_cast<std::uint32_t>(i));
  pass.pipeline.targets.colours.clear();
  for (const Attachment& colour : pass.colours)
    pass.pipeline.targets.colours.push_back(colour.image->description().format);
  pass.pipeline.targets.depth = pass.depth ? pass.depth->description().format : VK_FORMAT_UNDEFINED;
  Step step;
  step.timing = timing(pass.name);
  step.uses = uses_of(pass.bindings, VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
  add_addressed(step.uses, pass, VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT);
  for (Buffer* buffer : pass.indices_and_indirect)
    step.uses.push_back(
        {buffer,
         nullptr,
         {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_INDEX_READ_BIT | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED}});
  for (std::size_t i = 0; i < pass.colours.size(); ++i) {
    Image* const image = pass.colours[i].image;
    // Layers of one image share its state: one barrier for them all.
    bool seen = false;
    for (std::size_t k = 0; k < i; ++k) seen = seen || pass.colours[k].image == image;
    if (seen) continue;
    step.uses.push_back({nullptr,
                         image,
                         {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                          VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                              VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT,
                          ordered ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL}});
  }
  if (pass.depth)
    step.uses.push_back(
        {nullptr,
         pass.depth,
         {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
          VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
          VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}});

  const auto require = [&](const RasterDescription& pipeline) {
    require_interface(pass.name, {pipeline.vertex, pipeline.fragment}, supplied, pipeline.constants, pass.bindings,
                      pass.push, step.uses);
  };
  require(pass.pipeline);
  for (RasterDescription& alternative : pass.alternatives) {
    alternative.targets = pass.pipeline.targets;
    require(alternative);
  }
  const Pipeline& pipeline = device_.pipelines().raster(pass.pipeline);
  pipelines_.push_back(&pipeline);
  const VkRenderPass render_pass = device_.pipelines().render_pass(pass.pipeline.targets);
  const VkFramebuffer target = framebuffer(pass, render_pass);
  const VkExtent2D extent = extent_of(pass);
  timings_[step.timing].times_all += pass.triangles == Triangles::all ? 1 : 0;
  if (!pass.draws) timings_[step.timing].screen_pixels += std::uint64_t{extent.width} * extent.height;
  step.record = [this, &pipeline, render_pass, target, extent, ordered,
                 pass = std::move(pass)](VkCommandBuffer commands) {
    std::vector<VkClearValue> clears;
    for (const auto& bits : pass.clear_colours) {
      VkClearValue value{};
      std::copy(bits.begin(), bits.end(), value.color.uint32);
      clears.push_back(value);
    }
    clears.resize(pass.colours.size());
    VkClearValue depth{};
    depth.depthStencil = {pass.clear_depth, 0};
    if (pass.depth) clears.push_back(depth);
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = render_pass;
    begin.framebuffer = target;
    begin.renderArea.extent = extent;
    begin.clearValueCount = static_cast<std::uint32_t>(clears.size());
    begin.pClearValues = clears.data();
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get());
    bind(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pass.bindings, ordered ? pass.colours : std::vector<Attachment>{});
    DrawEncoder encoder(device_, commands, pass);
    encoder.push(pass.push);
    const auto height = static_cast<float>(pass.frame_rows > 0 ? pass.frame_rows : extent.height);
    encoder.viewport(0, -static_cast<float>(pass.first_row), static_cast<float>(extent.width), height);
    VkRect2D scissor{{0, 0}, extent};
    if (pass.scissor_rows[1] > 0) {
      scissor.offset.y = static_cast<std::int32_t>(pass.scissor_rows[0]);
      scissor.extent.height = pass.scissor_rows[1];
    }
    vkCmdSetScissor(commands, 0, 1, &scissor);
    if (pass.draws)
      pass.draws(encoder);
    else
      encoder.draw(3);
    vkCmdEndRenderPass(commands);
  };
  steps_.push_back(std::move(step));
}

void PassRecorder::fill(const std::string& name, Buffer& buffer, std::uint32_t value) {
  Step step;
  step.timing = timing(name);
  step.uses = {{&buffer,
                nullptr,
                {VK_PIPELINE_STAGE_2_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED}}};
  step.record = [&buffer, value](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, value);
  };
  steps_.push_back(std::move(step));
}

void PassRecorder::host(std::function<void()> work) {
  Step step;
  step.host = std::move(work);
  step.is_pass = false;
  steps_.push_back(std::move(step));
}

void PassRecorder::host_pass(const std::string& name, std::function<void()> work) {
  Step step;
  step.timing = timing(name);
  step.host = std::move(work);
  steps_.push_back(std::move(step));
}

void PassRecorder::run() {
  // Passes of one name (the bands or sample groups of one logical pass) count as one.
  std::vector<double> totals(timings_.size(), 0.0);
  for (auto& step : steps_) {
    if (step.host) {
      if (step.is_pass)
        totals[step.timing] += device_.run_on_host(step.host);
      else
        step.host();
      continue;
    }
    totals[step.timing] += device_.run(timings_[step.timing].name, [&](VkCommandBuffer commands) {
      barrier(commands, step.uses);
      step.record(commands);
    });
  }
  for (std::size_t i = 0; i < totals.size(); ++i) timings_[i].ms.push_back(totals[i]);
}

}  // namespace subpixel::gpu
