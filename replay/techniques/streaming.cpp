// Streaming G-buffer compression: one ordered geometry pass keeps up to S surfaces a pixel, merging fragments of one
// feature and discarding what the array can't hold; the resolve finds each sample's surface and lights those that show.
// Kerzner and Salvi, "Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing", High-Performance Graphics 2014.
#include "replay/techniques/streaming.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <memory>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/streaming/streaming_interface.h"

namespace subpixel::replay {
namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT, kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;

gpu::Constants streaming_constants(const StreamingSetup& setup) {
  const StreamingParameters& p = setup.parameters;
  std::uint32_t options = 0;
  if (p.merge_normals) options |= STREAM_MERGE_NORMALS;
  if (p.merge_depth) options |= STREAM_MERGE_DEPTH;
  if (p.merge_coverage) options |= STREAM_MERGE_COVERAGE;
  if (p.merge_weight == StreamingWeight::coverage) options |= STREAM_WEIGHT_COVERAGE;
  if (p.occlusion == StreamingOcclusion::depth_test) options |= STREAM_DEPTH_TESTED;
  if (p.depth_space == StreamingDepth::clip) options |= STREAM_CLIP_SPACE;
  const auto cosine = static_cast<float>(std::cos(p.normal_angle));
  return {{STREAM_CONSTANT_SURFACES, p.surfaces},
          {STREAM_CONSTANT_COS_NORMAL_ANGLE, std::bit_cast<std::uint32_t>(cosine)},
          {STREAM_CONSTANT_OPTIONS, options}};
}

void append(gpu::Constants& constants, const gpu::Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

MemoryLayout layout(const StreamingSetup& setup) {
  const double n = setup.samples, s = setup.parameters.surfaces;
  // Depth 32, derivatives 2 x 16, two masks, albedo 32, normal 32; up to 16 samples the masks fit the paper's 20 bytes.
  const double masks = std::max(2 * n, 32.0);
  const double exact = 32 + 32 + 2 * n + fitted_surface_bits(setup.scene.features());
  MemoryLayout memory;
  memory.paper = {{"depth", 32 * n}, {"count word", 32}, {"surfaces", (32 + 32 + masks + 32 + 32) * s}};
  memory.fitted = {{"depth", 32 * n}, {"count word", 32}, {"surfaces", exact * s}};
  return memory;
}

// Where the state lies: up to 32 words in attachments, whose order the device promises; more in a buffer.
struct State {
  gpu::Image* image = nullptr;
  gpu::Buffer* words = nullptr;
  gpu::AddressTable* address = nullptr;
  std::string variant() const { return image ? "IMAGE" : "BUFFER"; }
  void bind_for_reading(gpu::RasterPass& pass) const {
    if (image) {
      pass.bindings.push_back(gpu::samples(ORDERED_SLOT_ATTACHMENTS, *image));
    } else {
      pass.bindings.push_back(gpu::reads(ORDERED_SLOT_ADDRESS, *address));
    }
  }
};

State make_state(gpu::PassRecorder& recorder, const StreamingSetup& setup, bool in_buffer) {
  const std::uint32_t quads = STREAM_STATE_QUADS(setup.samples, setup.scene.features().bits, setup.parameters.surfaces);
  State state;
  if (quads <= ORDERED_MOST_ATTACHMENTS && !in_buffer) {
    state.image = &recorder.image({"streaming state", kWords, setup.width, setup.height, 1,
                                   std::max<std::uint32_t>(quads, ORDERED_FEWEST_ATTACHMENTS), VK_SAMPLE_COUNT_1_BIT,
                                   kTarget, true});
  } else {
    state.words = &recorder.buffer("streaming state", state_pixels(setup) * quads * 16);
    state.address = &recorder.address_table("streaming state address", sizeof(VkDeviceAddress));
    state.address->set(state.address->of(*state.words));
  }
  return state;
}

void record_compression(gpu::PassRecorder& recorder, const StreamingSetup& setup, const State& state) {
  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "compress";
  pass.pipeline.constants = common_constants(setup);
  append(pass.pipeline.constants, streaming_constants(setup));
  if (state.image) {
    const std::uint32_t attachments = state.image->description().layers;
    geometry.fragment_opaque = fmt::format("techniques/streaming/compress.frag:{}", attachments);
    pass.pipeline.targets.ordered_read = true;
    pass.pipeline.targets.clear = true;
    for (std::uint32_t i = 0; i < attachments; ++i) pass.colours.emplace_back(*state.image, i);
    pass.clear_colours.assign(attachments, {});
  } else {
    geometry.fragment_opaque = std::string("techniques/streaming/compress.frag:") + buffer_variant(recorder.device());
    recorder.fill("compress", *state.words, 0);
    pass.bindings.push_back(gpu::writes(ORDERED_SLOT_ADDRESS, *state.address));
    pass.size = {setup.width, setup.height};
  }
  setup.frontend.record_geometry(recorder, std::move(geometry));
}

// The same state by passes over fragment lists.
void record_list_compression(gpu::PassRecorder& recorder, const StreamingSetup& setup, const FragmentLists& lists,
                             const State& state) {
  gpu::Buffer& passed = recorder.buffer("passed fragments", std::uint64_t{setup.width} * setup.height * 4);
  gpu::Buffer& surfaces = recorder.buffer("fragment surfaces", lists.count * sizeof(gpu_types::StreamListedSurface));
  gpu::AddressTable& surfaces_address = recorder.address_table("fragment surfaces address", sizeof(VkDeviceAddress));
  surfaces_address.set(surfaces_address.of(surfaces));

  ListedPass listed;
  listed.constants = common_constants(setup);
  append(listed.constants, streaming_constants(setup));
  if (setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    listed.name = "alpha";
    listed.shader = "techniques/streaming/alpha.comp";
    listed.alpha_only = true;
    record_listed_fragments(recorder, setup, lists, listed);
    listed.alpha_only = false;
  }

  gpu::ComputePass by_pixel;
  by_pixel.constants = setup.frontend.constants();
  append(by_pixel.constants, streaming_constants(setup));
  by_pixel.bindings = {gpu::uniform(setup.scene.frame_constants)};
  by_pixel.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};

  gpu::ComputePass test = by_pixel;
  test.name = "depth test";
  test.shader = "techniques/streaming/depth_test.comp";
  const gpu_types::StreamDepthTestPush test_push{.lists = lists.writes(test),
                                                 .records = test.reads(setup.frontend.records()),
                                                 .state = test.writes(*state.words),
                                                 .passed = test.writes(passed),
                                                 .width = setup.width,
                                                 .height = setup.height};
  test.push = gpu::PushConstants(test_push);
  recorder.compute(std::move(test));

  listed.name = "attributes";
  listed.shader = "techniques/streaming/attributes.comp";
  listed.bindings = {gpu::writes(STREAM_SLOT_SURFACES, surfaces_address)};
  record_listed_fragments(recorder, setup, lists, listed);

  gpu::ComputePass merge = by_pixel;
  merge.name = "merge";
  merge.shader = "techniques/streaming/merge.comp";
  const gpu_types::StreamMergePush merge_push{.lists = lists.reads(merge),
                                              .surfaces = merge.reads(surfaces),
                                              .state = merge.writes(*state.words),
                                              .passed = merge.reads(passed),
                                              .width = setup.width,
                                              .height = setup.height};
  merge.push = gpu::PushConstants(merge_push);
  recorder.compute(std::move(merge));
}

void record_shading(gpu::PassRecorder& recorder, const StreamingSetup& setup, const State& state) {
  const gpu::ImageDescription output{"output", kFloats, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                     kTarget,  false};
  setup.outputs.radiance = &recorder.image(output);
  setup.outputs.display = &recorder.image(output);
  gpu::RasterPass pass = lighting_pass(setup, "shade", "techniques/streaming/shade.frag:" + state.variant());
  append(pass.pipeline.constants, streaming_constants(setup));
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  state.bind_for_reading(pass);
  recorder.raster(std::move(pass));
}

// The maps are read off the state in a host step, so that they cost the technique no time, and once, since every run
// leaves the same state.
void record_maps(gpu::PassRecorder& recorder, const StreamingSetup& setup, const State& state) {
  std::vector<gpu::Image*> maps;
  for (const char* name : {"merges", "discards", "surfaces", "order_errors"}) {
    maps.push_back(&recorder.image(
        {name, VK_FORMAT_R32_UINT, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT, kTarget, false}));
    setup.outputs.maps.emplace_back(name, maps.back());
  }
  gpu::RasterPass pass;
  pass.name = "maps";
  pass.pipeline.vertex = "shade/fullscreen.vert";
  pass.pipeline.fragment = "techniques/streaming/maps.frag:" + state.variant();
  pass.pipeline.constants = setup.frontend.constants();
  append(pass.pipeline.constants, streaming_constants(setup));
  for (gpu::Image* map : maps) pass.colours.emplace_back(*map);
  pass.bindings = {gpu::uniform(setup.scene.frame_constants)};
  state.bind_for_reading(pass);
  recorder.host([&device = recorder.device(), pass = std::move(pass), done = false]() mutable {
    if (done) return;
    gpu::PassRecorder own(device);
    own.raster(pass);
    own.run();
    done = true;
  });
}

}  // namespace

StreamingState record_streaming(gpu::PassRecorder& recorder, const StreamingSetup& setup) {
  setup.frontend.record_setup(recorder);
  const auto lists = record_measured_lists(recorder, setup, "collect");
  const State state = make_state(recorder, setup, lists.has_value());
  if (lists)
    record_list_compression(recorder, setup, *lists, state);
  else
    record_compression(recorder, setup, state);
  record_shading(recorder, setup, state);
  record_maps(recorder, setup, state);
  return {state.image, state.words};
}

extern const Technique kStreaming;

const Technique kStreaming = TechniqueOf<StreamingParameters>{
    .name = "streaming",
    .title = "Streaming G-buffer compression",
    .paper =
        "Kerzner, Salvi: Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing. High-Performance Graphics "
        "2014",
    .fields = {field::integer("surfaces", &StreamingParameters::surfaces, {1, STREAM_MAX_SURFACES},
                              "surfaces kept for a pixel"),
               field::samples({4, 8, 16, 32}),
               field::angle("normal_angle", &StreamingParameters::normal_angle,
                            "largest angle between the normals of fragments that merge"),
               field::condition("merge_normals", &StreamingParameters::merge_normals,
                                "fragments merge only when their normals align"),
               field::condition("merge_depth", &StreamingParameters::merge_depth,
                                "fragments merge only when their depth intervals overlap"),
               field::condition("merge_coverage", &StreamingParameters::merge_coverage,
                                "fragments merge only when they share no sample"),
               field::choice("merge_weight", &StreamingParameters::merge_weight,
                             "a merge weights both sides equally, or by the samples they cover",
                             {{"equal", StreamingWeight::equal}, {"coverage", StreamingWeight::coverage}}),
               field::choice(
                   "occlusion", &StreamingParameters::occlusion,
                   "what takes a sample from the surfaces behind: a nearer depth interval, as published, or the "
                   "depth test of the sample",
                   {{"intervals", StreamingOcclusion::intervals}, {"depth_test", StreamingOcclusion::depth_test}}),
               field::choice("depth_space", &StreamingParameters::depth_space,
                             "surfaces keep depth and derivatives along the view, or of the depth buffer",
                             {{"view", StreamingDepth::view}, {"clip", StreamingDepth::clip}}),
               field::order(), field::alpha(), field::resolve(), field::shading()},
    .maps = {{"merges", "Fragments merged", "fragments", 16},
             {"discards", "Samples discarded while visible", "samples", 8},
             {"surfaces", "Surfaces stored", "surfaces", 4},
             {"order_errors", "Surfaces out of order", "surfaces", 4}},
    .layout = layout,
    .record = [](gpu::PassRecorder& recorder, const StreamingSetup& setup) { record_streaming(recorder, setup); },
    .lists = ListedMasks::collected,
};

}  // namespace subpixel::replay
