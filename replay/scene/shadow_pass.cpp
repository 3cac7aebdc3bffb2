#include "replay/scene/shadow_pass.hpp"

#include <algorithm>
#include <array>

#include "replay/gpu/pass_recorder.hpp"
#include "shaders/scene/scene_interface.h"

namespace subpixel::replay {
namespace {

// Draws [first, first + count) of one cascade.
struct CasterBatch {
  bool tested = false;
  std::uint32_t material = 0;  // of tested ones
  std::uint32_t first = 0, count = 0;
};

struct CasterDraw {
  std::uint32_t indices, first_index, first_instance, instances;
};

struct Casters {
  std::vector<CasterDraw> draws;
  std::array<std::vector<CasterBatch>, SUBPIXEL_SHADOW_CASCADES> batches;
};

// True when some of `bounds` is over the cascade. Its own box in the sun's view is tested: a little too large, never
// too small.
bool casts_into(const Bounds& bounds, const glm::dmat4& world_to_clip) {
  const Bounds seen = transformed(bounds, world_to_clip);
  return !seen.empty() && seen.low.x <= 1 && seen.high.x >= -1 && seen.low.y <= 1 && seen.high.y >= -1;
}

// One draw for each run of neighbouring instances; those without alpha test first, as one batch.
Casters select_casters(const GpuScene& scene, const std::vector<Bounds>& instance_bounds, const ShadowFit& fit) {
  Casters casters;
  for (std::size_t c = 0; c < fit.cascades.size(); ++c) {
    if (fit.cascades[c].scale == 0) continue;
    const glm::dmat4 to_clip = fit.world_to_clip(c);
    auto& batches = casters.batches[c];
    for (const bool tested : {false, true}) {
      for (const auto& draw : scene.draws()) {
        if (scene.alpha_tested(draw.material) != tested) continue;
        const auto first = static_cast<std::uint32_t>(casters.draws.size());
        bool in_run = false;
        for (std::uint32_t i = draw.first_instance; i < draw.first_instance + draw.instance_count; ++i) {
          const bool casts = casts_into(instance_bounds[i], to_clip);
          if (casts && !in_run) casters.draws.push_back({3 * draw.triangle_count, draw.first_index, i, 0});
          if (casts) ++casters.draws.back().instances;
          in_run = casts;
        }
        const auto count = static_cast<std::uint32_t>(casters.draws.size()) - first;
        if (count == 0) continue;
        const bool joins = !batches.empty() && batches.back().tested == tested &&
                           (!tested || batches.back().material == draw.material);
        if (joins)
          batches.back().count += count;
        else
          batches.push_back({tested, draw.material, first, count});
      }
    }
  }
  return casters;
}

}  // namespace

void render_shadow_map(gpu::Device& device, GpuScene& scene, const std::vector<Bounds>& instance_bounds,
                       const ShadowFit& fit) {
  const Casters casters = select_casters(scene, instance_bounds, fit);
  gpu::PassRecorder recorder(device);
  gpu::RasterPass pass;
  pass.name = "shadow map";
  pass.pipeline.vertex = "scene/shadow.vert:SOLID";
  pass.pipeline.targets.clear = true;
  pass.pipeline.depth_compare = VK_COMPARE_OP_LESS;
  pass.pipeline.depth_write = true;
  gpu::RasterDescription& tested = pass.alternatives.emplace_back(pass.pipeline);
  const std::string variant = scene.features().has(FEATURE_VERTEX_COLOUR) ? "COLOURED" : "TESTED";
  tested.vertex = "scene/shadow.vert:" + variant;
  tested.fragment = "scene/shadow.frag:" + variant;
  tested.constants = {{CONSTANT_FEATURES, scene.features().bits}};
  pass.depth = &scene.shadow_map;
  pass.clear_depth = 1;
  pass.bindings = {gpu::uniform(scene.frame_constants), gpu::reads(FRAME_SLOT_MATERIALS, scene.materials),
                   gpu::reads(FRAME_SLOT_UV_MAPPINGS, scene.uv_mappings)};
  pass.indices_and_indirect = {&scene.indices};
  const std::uint64_t uvs = pass.reads(scene.uvs), second_uvs = pass.reads(scene.second_uvs);
  gpu_types::ShadowPush push{.world_to_clip = glm::mat4(1),
                             .positions = pass.reads(scene.positions),
                             .uvs = uvs,
                             .instances = pass.reads(scene.instances),
                             .colours = pass.reads(scene.colours),
                             .material = 0};
  pass.push = gpu::PushConstants(push);
  const auto side = static_cast<float>(scene.shadow_map.description().width / 2);
  pass.draws = [&](gpu::DrawEncoder& encoder) {
    encoder.index_buffer(scene.indices);
    for (std::uint32_t c = 0; c < SUBPIXEL_SHADOW_CASCADES; ++c) {
      encoder.viewport(static_cast<float>(c & 1) * side, static_cast<float>(c >> 1) * side, side, side);
      push.world_to_clip = glm::mat4(fit.world_to_clip(c));
      for (const auto& batch : casters.batches[c]) {
        encoder.pipeline(batch.tested ? 1 : 0);
        if (batch.tested) encoder.material(scene.material_set(batch.material));
        push.material = batch.material;
        push.uvs = scene.second_uv_of_base(batch.material) ? second_uvs : uvs;
        encoder.push(gpu::PushConstants(push));
        for (std::uint32_t i = batch.first; i < batch.first + batch.count; ++i) {
          const CasterDraw& draw = casters.draws[i];
          encoder.draw_indexed(draw.indices, draw.instances, draw.first_index, draw.first_instance);
        }
      }
    }
  };
  recorder.raster(std::move(pass));
  recorder.run();
}

}  // namespace subpixel::replay
