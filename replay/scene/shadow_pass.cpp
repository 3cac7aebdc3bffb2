#include "replay/scene/shadow_pass.hpp"

#include <algorithm>

namespace subpixel::replay {
namespace {

struct ShadowPush {
  glm::mat4 world_to_clip;
  VkDeviceAddress positions, uvs, instances;
  std::uint32_t material;
};

}  // namespace

void write_indirect_commands(const std::vector<DrawItem>& draws, gpu::Buffer& commands) {
  const auto to = commands.as<VkDrawIndexedIndirectCommand>();
  for (std::size_t i = 0; i < draws.size(); ++i)
    to[i] = {draws[i].triangle_count * 3, draws[i].instance_count, draws[i].first_index, 0, draws[i].first_instance};
}

void render_shadow_map(gpu::Device& device, GpuScene& scene, gpu::Buffer& commands, const ShadowFit& fit) {
  std::vector<DrawItem> draws = scene.draws();
  const auto cut = std::stable_partition(draws.begin(), draws.end(),
                                         [&](const DrawItem& draw) { return !scene.alpha_tested(draw.material); });
  const auto solid = static_cast<std::uint32_t>(cut - draws.begin());
  write_indirect_commands(draws, commands);

  gpu::RasterPass pass;
  pass.name = "shadow map";
  pass.pipeline.vertex = "scene/shadow.vert:SOLID";
  pass.pipeline.targets.depth = VK_FORMAT_D32_SFLOAT;
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_LESS;
  pass.pipeline.depth_write = true;
  const gpu::RasterDescription opaque = pass.pipeline;
  gpu::RasterDescription tested = pass.pipeline;
  tested.vertex = "scene/shadow.vert:TESTED";
  tested.fragment = "scene/shadow.frag";
  tested.constants = {{1, scene.features().bits}};
  pass.depth = &scene.shadow_map;
  pass.clear_depth = 1;
  pass.bindings = {gpu::uniform(scene.frame_constants), gpu::reads(0, scene.materials)};
  pass.indices_and_indirect = {&scene.indices, &commands};
  pass.by_address = {&scene.positions, &scene.uvs, &scene.instances};
  ShadowPush push{glm::mat4(1), scene.positions.address(), scene.uvs.address(), scene.instances.address(), 0};
  pass.push = gpu::PushConstants(push);
  const auto side = static_cast<float>(scene.shadow_map.description().width / 2);
  pass.draws = [&](gpu::DrawEncoder& encoder) {
    encoder.index_buffer(scene.indices);
    for (std::uint32_t c = 0; c < SUBPIXEL_SHADOW_CASCADES; ++c) {
      if (fit.cascades[c].scale == 0) continue;
      encoder.viewport(static_cast<float>(c & 1) * side, static_cast<float>(c >> 1) * side, side, side);
      push.world_to_clip = glm::mat4(fit.world_to_clip(c));
      encoder.push(gpu::PushConstants(push));
      encoder.pipeline(opaque);
      if (solid > 0) encoder.draw_indexed_indirect(commands, 0, solid);
      if (solid < draws.size()) encoder.pipeline(tested);
      for (std::size_t i = solid; i < draws.size(); ++i) {
        if (i == solid || draws[i].material != draws[i - 1].material) {
          push.material = draws[i].material;
          encoder.push(gpu::PushConstants(push));
          encoder.material(scene.material_set(draws[i].material));
        }
        encoder.draw_indexed_indirect(commands, i * sizeof(VkDrawIndexedIndirectCommand), 1);
      }
    }
  };
  gpu::PassRecorder recorder(device);
  recorder.raster(std::move(pass));
  recorder.run();
}

}  // namespace subpixel::replay
