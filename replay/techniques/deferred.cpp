#include "replay/techniques/deferred.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/error.hpp"
#include "replay/frame/pixel_story.hpp"
#include "replay/frontend/list_passes.hpp"
#include "replay/frontend/visibility.hpp"
#include "shaders/deferred/deferred_interface.h"
#include "shaders/frontend/frontend_interface.h"
#include "shaders/shade/shade_interface.h"

namespace subpixel::replay {

MemoryLayout full_sample_layout(const FrameSetup& setup) {
  const double n = setup.samples;
  // 16-byte G-buffer sample and 32-bit depth, as in the tables of the papers that use it as their baseline.
  return {{"depth", 32 * n}, {"G-buffer samples", 128 * n}};
}

bool narrow_samples(const FrameSetup& setup) {
  const SceneFeatures features = setup.scene.features();
  return !features.has(FEATURE_EMISSIVE) && !(features.has(FEATURE_METAL) && features.has(FEATURE_VARYING_ROUGHNESS));
}

std::uint32_t gbuffer_group(std::uint32_t samples) {
  return std::min(samples, 8u);
}

VkFormat stored_sample_format(const FrameSetup& setup) {
  return narrow_samples(setup) ? VK_FORMAT_R16G16B16A16_UINT : VK_FORMAT_R32G32B32A32_UINT;
}

const char* stored_sample_variant(const FrameSetup& setup) {
  return narrow_samples(setup) ? ":NARROW" : ":WIDE";
}

gpu::Image& stored_samples(gpu::PassRecorder& recorder, const FrameSetup& setup, std::string name,
                           std::uint32_t layers) {
  return recorder.image({std::move(name), stored_sample_format(setup), setup.width, setup.height, 1, layers,
                         VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
}

gpu::Image& gbuffer_image(gpu::PassRecorder& recorder, const FrameSetup& setup, bool all_samples) {
  return stored_samples(recorder, setup, "G-buffer", all_samples ? setup.samples : gbuffer_group(setup.samples));
}

void record_gbuffer(gpu::PassRecorder& recorder, const FrameSetup& setup, const VisibleFragments& visible,
                    gpu::Image& gbuffer, std::uint32_t group) {
  const std::uint32_t count = gbuffer_group(setup.samples);
  ListedPass pass;
  pass.name = "gbuffer";
  pass.shader = std::string("deferred/gbuffer.comp") + stored_sample_variant(setup);
  pass.constants = common_constants(setup);
  gpu::append(pass.constants,
              {{CONSTANT_SAMPLE_GROUP, group},
               {CONSTANT_GROUP_SAMPLES, count},
               {DEFERRED_CONSTANT_FIRST_LAYER, gbuffer.description().layers > count ? group * count : 0}});
  pass.bindings = {gpu::image_writes(DEFERRED_SLOT_SAMPLES, gbuffer)};
  record_listed_fragments(recorder, setup, visible.lists, pass);
}

SampleImages record_gbuffer_in_order(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = visibility_image(recorder, setup);
  gpu::Image& gbuffer =
      recorder.image({"G-buffer", VK_FORMAT_R32G32B32A32_UINT, setup.width, setup.height, 1, setup.samples,
                      VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
  gpu::Buffer& written = recorder.buffer("fragments written", std::uint64_t{setup.width} * setup.height * 4);
  recorder.fill("gbuffer", written, 0);
  const std::uint32_t group = visibility_group(setup.frontend);
  for (std::uint32_t g = 0; g < setup.samples / group; ++g) {
    Frontend::GeometryPass geometry;
    geometry.by_material = true;
    geometry.fragment_opaque = "deferred/gbuffer_in_order.frag:" + std::to_string(group);
    gpu::RasterPass& pass = geometry.pass;
    pass.name = "gbuffer";
    pass.pipeline.constants = common_constants(setup);
    pass.pipeline.constants.emplace_back(FRONTEND_CONSTANT_AFTER_SMALL, 0);
    pass.pipeline.targets.clear = true;
    attach_visibility(pass, setup.frontend, visibility, g);
    pass.bindings = {gpu::image_writes(DEFERRED_SLOT_SAMPLES, gbuffer), gpu::writes(DEFERRED_SLOT_WRITTEN, written)};
    setup.frontend.record_geometry(recorder, std::move(geometry));
  }
  gpu::RasterPass maps = fullscreen_pass(setup, "maps", "deferred/written_map.frag");
  maps.colours = make_maps(recorder, setup, {"written"});
  maps.bindings.push_back(gpu::reads(DEFERRED_SLOT_WRITTEN, written));
  recorder.host(once(run_pass(recorder.device(), std::move(maps))));
  return {visibility, gbuffer};
}

MapDescription written_map() {
  return {"written", "Fragments stored, hidden later or not", "fragments", 16};
}

namespace field {
Field<PrepassParameters> prepass() {
  return condition("prepass", &PrepassParameters::prepass,
                   "visibility is found before attributes are evaluated; false: both in one pass in submission order, "
                   "which pays for what is hidden later; the same image");
}
}  // namespace field

gpu::Image& sum_image(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  constexpr VkImageUsageFlags kUsage =
      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  return recorder.image(
      {"sum", VK_FORMAT_R32G32B32A32_SFLOAT, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT, kUsage, false});
}

PixelList record_pixel_list(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& flags) {
  constexpr std::uint32_t kTile = 8;
  const std::uint32_t tiles = ((setup.width + kTile - 1) / kTile) * ((setup.height + kTile - 1) / kTile);
  gpu::Buffer& sums = recorder.buffer("tile sums", (std::uint64_t{tiles} + 1) * 16);
  gpu::Buffer& counts = recorder.buffer("tile counts", std::uint64_t{tiles} * 4);
  const PixelList list{&recorder.buffer("pixel list", (std::uint64_t{setup.width} * setup.height + 1) * 4),
                       &recorder.buffer("pixel list groups", 12)};
  gpu::ComputePass pass;
  pass.name = "compact";
  pass.shader = "deferred/count_pixels.comp";
  pass.bindings = {gpu::samples(DEFERRED_SLOT_FLAGS, flags), gpu::writes(DEFERRED_SLOT_TILE_SUMS, sums),
                   gpu::writes(DEFERRED_SLOT_TILE_COUNTS, counts)};
  pass.groups = {(tiles + 63) / 64, 1, 1};
  recorder.compute(pass);

  record_scan(recorder, "compact", sums, tiles);

  pass.shader = "deferred/list_pixels.comp";
  pass.bindings = {gpu::samples(DEFERRED_SLOT_FLAGS, flags), gpu::reads(DEFERRED_SLOT_TILE_SUMS, sums),
                   gpu::writes(DEFERRED_SLOT_PIXEL_LIST, *list.pixels),
                   gpu::writes(DEFERRED_SLOT_GROUPS, *list.groups)};
  recorder.compute(std::move(pass));

  recorder.host([&counts, list] {
    const auto parts = counts.as<std::uint32_t>();
    const std::uint32_t expected = std::accumulate(parts.begin(), parts.end(), 0u);
    const std::uint32_t listed = list.pixels->as<std::uint32_t>()[0];
    if (listed != expected)
      throw DeviceError("pixel list", fmt::format("the device counted {} pixels of {}", listed, expected),
                        "pass compact");
  });
  return list;
}

std::vector<gpu::Binding> light_bindings(const FrameSetup& setup) {
  return {gpu::reads(FRAME_SLOT_SPOT_CONES, setup.scene.spot_cones),
          gpu::reads(FRAME_SLOT_LIGHT_CELLS, setup.scene.light_cells),
          gpu::samples(FRAME_SLOT_SHADOW_MAP, setup.scene.shadow_map, &setup.scene.shadow_sampler)};
}

gpu::RasterPass lighting_pass(const FrameSetup& setup, std::string name, std::string fragment) {
  gpu::RasterPass pass = fullscreen_pass(setup, std::move(name), std::move(fragment));
  for (const gpu::Binding& light : light_bindings(setup)) pass.bindings.push_back(light);
  return pass;
}

void record_sample_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& visibility,
                           gpu::Image& gbuffer, gpu::Image& sum, std::uint32_t group) {
  gpu::RasterPass pass = lighting_pass(setup, "shade", "shade/samples.frag");
  pass.pipeline.constants.emplace_back(CONSTANT_SAMPLE_GROUP, group);
  pass.pipeline.constants.emplace_back(CONSTANT_GROUP_SAMPLES, gbuffer_group(setup.samples));
  pass.pipeline.targets.clear = group == 0;
  pass.pipeline.additive = true;
  pass.colours = {{sum}};
  pass.clear_colours = {{}};
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  pass.bindings.push_back(gpu::samples(SHADE_SLOT_GBUFFER, gbuffer));
  if (setup.story != nullptr) setup.story->record_lighting(recorder, pass, "shade/samples.frag:STORY");
  recorder.raster(std::move(pass));
}

gpu::Image& record_shaded_samples(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  return record_shaded_samples(recorder, setup, record_visible(recorder, setup));
}

gpu::Image& record_shaded_samples(gpu::PassRecorder& recorder, const FrameSetup& setup,
                                  const VisibleFragments& visible) {
  gpu::Image& gbuffer = gbuffer_image(recorder, setup);
  gpu::Image& sum = sum_image(recorder, setup);
  for (std::uint32_t group = 0; group < setup.samples / gbuffer_group(setup.samples); ++group) {
    record_gbuffer(recorder, setup, visible, gbuffer, group);
    record_sample_shading(recorder, setup, *visible.visibility, gbuffer, sum, group);
  }
  return sum;
}

void record_resolve(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& sum) {
  gpu::RasterPass pass = fullscreen_pass(setup, "resolve", "shade/resolve.frag");
  pass.colours = make_outputs(recorder, setup);
  pass.pipeline.targets.clear = true;
  pass.clear_colours = {{}, {}};
  pass.bindings.push_back(gpu::samples(SHADE_SLOT_SUM, sum));
  recorder.raster(std::move(pass));
}

}  // namespace subpixel::replay
