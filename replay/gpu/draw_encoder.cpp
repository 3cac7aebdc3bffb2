#include <stdexcept>

#include "replay/gpu/pass_recorder.hpp"

namespace subpixel::gpu {

void DrawEncoder::push(const PushConstants& push) {
  if (push.size != pass_.push.size) throw std::logic_error("pass " + pass_.name + ": push constants of another size");
  vkCmdPushConstants(commands_, device_.pipelines().layout(), VK_SHADER_STAGE_ALL, 0, kPushConstantBytes,
                     push.bytes.data());
}
void DrawEncoder::pipeline(std::size_t number) {
  const RasterDescription& description = number == 0 ? pass_.pipeline : pass_.alternatives.at(number - 1);
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, device_.pipelines().raster(description).get());
}
void DrawEncoder::material(VkDescriptorSet set) {
  vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, device_.pipelines().layout(), 1, 1, &set, 0,
                          nullptr);
}
void DrawEncoder::index_buffer(const Buffer& buffer) {
  vkCmdBindIndexBuffer(commands_, buffer.handle(), 0, VK_INDEX_TYPE_UINT32);
}
void DrawEncoder::draw(std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex,
                       std::uint32_t first_instance) {
  vkCmdDraw(commands_, vertices, instances, first_vertex, first_instance);
}
void DrawEncoder::draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
                               std::uint32_t first_instance) {
  vkCmdDrawIndexed(commands_, indices, instances, first_index, 0, first_instance);
}
void DrawEncoder::draw_indexed_indirect(const Buffer& buffer, VkDeviceSize offset) {
  vkCmdDrawIndexedIndirect(commands_, buffer.handle(), offset, 1, sizeof(VkDrawIndexedIndirectCommand));
}
void DrawEncoder::viewport(float x, float y, float width, float height) {
  const VkViewport viewport{x, y, width, height, 0, 1};
  vkCmdSetViewport(commands_, 0, 1, &viewport);
}

}  // namespace subpixel::gpu
