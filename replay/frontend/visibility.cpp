#include "replay/frontend/visibility.hpp"

#include <algorithm>

#include "replay/frontend/fragment_lists.hpp"
#include "shaders/frontend/frontend_types.h"

namespace subpixel::replay {
namespace {

constexpr VkFormat kTexel = VK_FORMAT_R32G32B32A32_UINT;

// Layers of the image that group `g` has, its depths before its triangles.
struct Layers {
  std::uint32_t first, count;
};
Layers layers_of(std::uint32_t group, std::uint32_t g) {
  return group < 4 ? Layers{0, 1} : Layers{g * group / 2, group / 2};
}

// Keys carry a pixel through compute and back, which costs about what the hulls of 1/32 as many triangles do.
bool small_in_compute(const FrameSetup& setup, SmallTriangles small) {
  if (small != SmallTriangles::automatic) return small == SmallTriangles::in_compute;
  return 32 * setup.frontend.small_count() > std::uint64_t{setup.width} * setup.height;
}

gpu::Buffer& keys_buffer(gpu::PassRecorder& recorder, const FrameSetup& setup, std::uint32_t group) {
  return recorder.buffer("visibility keys", std::uint64_t{setup.width} * setup.height * group * sizeof(std::uint64_t));
}

// Small triangles of sample group `g` into the image.
void record_small_triangles(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& image, gpu::Buffer& keys,
                            std::uint32_t group, std::uint32_t g) {
  Frontend& frontend = setup.frontend;
  const std::string variant = std::to_string(group);
  recorder.fill("visibility", keys, 0);
  const auto groups = static_cast<std::uint32_t>((frontend.small_count() + 63) / 64);
  const std::uint32_t runs = device_runs();
  struct {
    std::uint64_t records, keys;
    std::uint32_t count, groups, runs, width, height;
  } const push{frontend.records().address(),
               keys.address(),
               static_cast<std::uint32_t>(frontend.small_count()),
               groups,
               runs,
               setup.width,
               setup.height};
  gpu::ComputePass rasterise;
  rasterise.name = "visibility";
  rasterise.shader = "frontend/small.comp:" + variant;
  rasterise.constants = frontend.constants();
  rasterise.constants.emplace_back(4, g);
  rasterise.bindings = {gpu::reads(0, frontend.small_records())};
  rasterise.by_address = {&frontend.records(), &keys};
  rasterise.push = gpu::PushConstants(push);
  rasterise.groups = {(groups + runs - 1) / runs * runs, 1, 1};
  recorder.compute(std::move(rasterise));

  struct {
    std::uint64_t keys;
    std::uint32_t width, height;
  } const store_push{keys.address(), setup.width, setup.height};
  gpu::RasterPass store;
  store.name = "visibility";
  store.pipeline.vertex = "shade/fullscreen.vert";
  store.pipeline.fragment = "frontend/store_keys.frag:" + variant;
  store.by_address = {&keys};
  store.push = gpu::PushConstants(store_push);
  const Layers layers = layers_of(group, g);
  for (std::uint32_t i = 0; i < layers.count; ++i) store.colours.emplace_back(image, layers.first + i);
  store.pipeline.targets.colours.assign(layers.count, kTexel);
  recorder.raster(std::move(store));
}

}  // namespace

std::uint32_t visibility_group(std::uint32_t samples) {
  return std::min(samples, 16u);
}

gpu::Image& record_visibility(gpu::PassRecorder& recorder, const FrameSetup& setup, SmallTriangles small) {
  const std::uint32_t group = visibility_group(setup.samples);
  const std::uint32_t quads = group / 4;  // 0 for one and two samples, whose depths and triangles share a texel
  const std::uint32_t layers = quads == 0 ? 1 : setup.samples / 2;
  gpu::Image& image = recorder.image(
      {"visibility", kTexel, setup.width, setup.height, 1, layers, VK_SAMPLE_COUNT_1_BIT,
       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
  gpu::Buffer* const keys = small_in_compute(setup, small) ? &keys_buffer(recorder, setup, group) : nullptr;
  if (keys) setup.frontend.record_small_list(recorder, "visibility");
  constexpr std::uint32_t kNone = SUBPIXEL_NO_TRIANGLE;
  for (std::uint32_t g = 0; g < setup.samples / group; ++g) {
    if (keys) record_small_triangles(recorder, setup, image, *keys, group, g);
    Frontend::GeometryPass geometry;
    geometry.without_small = keys != nullptr;
    gpu::RasterPass& pass = geometry.pass;
    pass.name = "visibility";
    const std::string variant = std::to_string(group);
    geometry.fragment_opaque = "frontend/visibility.frag:" + variant;
    geometry.fragment_alpha = "frontend/visibility.frag:" + variant + "A";
    pass.pipeline.constants = common_constants(setup);
    pass.pipeline.constants.emplace_back(4, g);
    pass.pipeline.targets.ordered_read = true;
    pass.pipeline.constants.emplace_back(7, keys ? 1 : 0);
    pass.pipeline.targets.clear = !keys;
    if (quads == 0) {
      pass.colours = {{image, 0}};
      pass.clear_colours = {{0, group == 1 ? kNone : 0, kNone, kNone}};
    } else {
      for (std::uint32_t layer = 0; layer < 2 * quads; ++layer) {
        pass.colours.emplace_back(image, g * 2 * quads + layer);
        pass.clear_colours.push_back(layer < quads ? std::array<std::uint32_t, 4>{}
                                                   : std::array<std::uint32_t, 4>{kNone, kNone, kNone, kNone});
      }
    }
    pass.pipeline.targets.colours.assign(pass.colours.size(), kTexel);
    setup.frontend.record_geometry(recorder, std::move(geometry));
  }
  setup.frontend.record_visible(recorder, image);
  return image;
}

}  // namespace subpixel::replay
