// Streaming G-buffer compression: one ordered geometry pass keeps up to S surfaces a pixel, merging fragments of one
// feature and discarding what the array can't hold; the resolve finds each sample's surface and lights those that show.
// Kerzner and Salvi, "Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing", High-Performance Graphics 2014.
#include "replay/techniques/streaming.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <memory>
#include <numbers>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/streaming/streaming_types.h"

namespace subpixel::replay {
namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT, kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
// Vulkan requires at least 4 colour attachments; devices that run us have 8.
constexpr std::uint32_t kMostAttachments = 8, kFewestAttachments = 3;

std::uint32_t surfaces(const FrameSetup& setup) {
  return static_cast<std::uint32_t>(setup.number("surfaces"));
}

// As in shaders/techniques/streaming/state.glsl.
std::uint32_t state_quads(const FrameSetup& setup) {
  const SceneFeatures features = setup.scene.features();
  const std::uint32_t surface_words = 5 + (setup.samples == 32 ? 1 : 0) +
                                      (setup.samples > 8 && features.has(FEATURE_VARYING_ROUGHNESS) ? 1 : 0) +
                                      (features.has(FEATURE_EMISSIVE) ? 1 : 0);
  return (setup.samples + 1 + surfaces(setup) * surface_words + 3) / 4;
}

gpu::Constants streaming_constants(const FrameSetup& setup) {
  std::uint32_t options = 0;
  const auto add = [&](std::string_view parameter, std::uint32_t option) {
    if (setup.parameters.at(std::string(parameter)).get<bool>()) options |= option;
  };
  add("merge_normals", STREAM_MERGE_NORMALS);
  add("merge_depth", STREAM_MERGE_DEPTH);
  add("merge_coverage", STREAM_MERGE_COVERAGE);
  if (setup.choice("merge_weight") == "coverage") options |= STREAM_WEIGHT_COVERAGE;
  if (setup.choice("occlusion") == "depth_test") options |= STREAM_DEPTH_TESTED;
  if (setup.choice("depth_space") == "clip") options |= STREAM_CLIP_SPACE;
  // With the depth test of each sample the stored masks are what shows.
  if (setup.choice("discard") == "resolved" || setup.choice("occlusion") == "depth_test")
    options |= STREAM_DISCARD_RESOLVED;
  const auto cosine = static_cast<float>(std::cos(setup.number("normal_angle")));
  return {{10, surfaces(setup)}, {11, std::bit_cast<std::uint32_t>(cosine)}, {12, options}};
}

void append(gpu::Constants& constants, const gpu::Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

MemoryLayout layout(const FrameSetup& setup) {
  const double n = setup.samples, s = surfaces(setup);
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
  gpu::Buffer* address = nullptr;
  std::string variant() const { return image ? "IMAGE" : "BUFFER"; }
  void bind_for_reading(gpu::RasterPass& pass) const {
    if (image) {
      pass.bindings.push_back(gpu::samples(0, *image));
    } else {
      pass.bindings.push_back(gpu::reads(0, *address));
      pass.by_address.push_back(words);
    }
  }
};

State make_state(gpu::PassRecorder& recorder, const FrameSetup& setup, bool in_buffer) {
  const std::uint32_t quads = state_quads(setup);
  State state;
  if (quads <= kMostAttachments && !in_buffer) {
    state.image = &recorder.image({"streaming state", kWords, setup.width, setup.height, 1,
                                   std::max(quads, kFewestAttachments), VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  } else {
    state.words = &recorder.buffer("streaming state", state_pixels(setup) * quads * 16);
    state.address = &recorder.buffer("streaming state address", sizeof(VkDeviceAddress));
    state.address->as<VkDeviceAddress>()[0] = state.words->address();
  }
  return state;
}

void record_compression(gpu::PassRecorder& recorder, const FrameSetup& setup, const State& state) {
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
    pass.pipeline.targets.colours.assign(attachments, kWords);
    for (std::uint32_t i = 0; i < attachments; ++i) pass.colours.emplace_back(*state.image, i);
    pass.clear_colours.assign(attachments, {});
  } else {
    geometry.fragment_opaque = std::string("techniques/streaming/compress.frag:") + buffer_variant(recorder.device());
    recorder.fill("compress", *state.words, 0);
    pass.bindings.push_back(gpu::reads(0, *state.address));
    pass.by_address.push_back(state.words);
    pass.size = {setup.width, setup.height};
  }
  setup.frontend.record_geometry(recorder, std::move(geometry));
}

// The same state by passes over fragment lists.
void record_list_compression(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists,
                             const State& state) {
  gpu::Buffer& passed = recorder.buffer("passed fragments", std::uint64_t{setup.width} * setup.height * 4);
  gpu::Buffer& surfaces = recorder.buffer("fragment surfaces", lists.count * 24);
  gpu::Buffer& surfaces_address = recorder.buffer("fragment surfaces address", sizeof(VkDeviceAddress));
  surfaces_address.as<VkDeviceAddress>()[0] = surfaces.address();

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

  struct {
    ListAddresses lists;
    std::uint64_t records_or_surfaces, state, passed;
    std::uint32_t width, height;
  } push{lists.by_address(), setup.frontend.records().address(), state.words->address(), passed.address(), setup.width,
         setup.height};
  gpu::ComputePass pass;
  pass.name = "depth test";
  pass.shader = "techniques/streaming/depth_test.comp";
  pass.constants = setup.frontend.constants();
  append(pass.constants, streaming_constants(setup));
  pass.bindings = {gpu::uniform(setup.scene.frame_constants)};
  pass.by_address = {lists.fragments,           lists.numbers, lists.ends, lists.bases,
                     &setup.frontend.records(), state.words,   &passed};
  pass.push = gpu::PushConstants(push);
  pass.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};
  recorder.compute(pass);

  listed.name = "attributes";
  listed.shader = "techniques/streaming/attributes.comp";
  listed.bindings = {gpu::reads(1, surfaces_address)};
  listed.by_address = {&surfaces};
  record_listed_fragments(recorder, setup, lists, listed);

  push.records_or_surfaces = surfaces.address();
  pass.name = "merge";
  pass.shader = "techniques/streaming/merge.comp";
  pass.by_address = {lists.fragments, lists.numbers, lists.ends, lists.bases, &surfaces, state.words, &passed};
  pass.push = gpu::PushConstants(push);
  recorder.compute(pass);
}

void record_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, const State& state) {
  const gpu::ImageDescription output{"output", kFloats, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                     kTarget,  false};
  setup.outputs.radiance = &recorder.image(output);
  setup.outputs.display = &recorder.image(output);
  gpu::RasterPass pass = lighting_pass(setup, "shade", "techniques/streaming/shade.frag:" + state.variant());
  append(pass.pipeline.constants, streaming_constants(setup));
  pass.pipeline.targets.colours = {kFloats, kFloats};
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  state.bind_for_reading(pass);
  recorder.raster(std::move(pass));
}

// The maps are read off the state in a host step, so that they cost the technique no time, and once, since every run
// leaves the same state.
void record_maps(gpu::PassRecorder& recorder, const FrameSetup& setup, const State& state) {
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
  pass.pipeline.targets.colours.assign(maps.size(), VK_FORMAT_R32_UINT);
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

StreamingState record_streaming(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  const auto lists = record_fragment_lists(recorder, setup, "collect", ListedMasks::collected);
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

const Technique kStreaming{
    "streaming",
    "Streaming G-buffer compression",
    "Kerzner, Salvi: Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing. High-Performance Graphics 2014",
    {integer_parameter("surfaces", "surfaces kept for a pixel", 1, STREAM_MAX_SURFACES, 3),
     samples_parameter({4, 8, 16, 32}, 8),
     number_parameter("normal_angle", "largest angle between the normals of fragments that merge", "radians", 0,
                      std::numbers::pi, std::numbers::pi / 4),
     condition_parameter("merge_normals", "fragments merge only when their normals align"),
     condition_parameter("merge_depth", "fragments merge only when their depth intervals overlap"),
     condition_parameter("merge_coverage", "fragments merge only when they share no sample"),
     choice_parameter("merge_weight", "a merge weights both sides equally, or by the samples they cover",
                      {"equal", "coverage"}),
     choice_parameter(
         "occlusion",
         "what takes a sample from the surfaces behind: a nearer depth interval, as published, or the depth test of "
         "the sample",
         {"intervals", "depth_test"}),
     choice_parameter("discard",
                      "which surface has to go: the one with the fewest samples that nothing nearer covers, as in the "
                      "authors' code, or with the smallest depth-resolved mask, as the text can be read",
                      {"uncovered", "resolved"}),
     choice_parameter("depth_space", "surfaces keep depth and derivatives along the view, or of the depth buffer",
                      {"view", "clip"}),
     order_parameter(), alpha_parameter(), resolve_parameter(), shading_parameter()},
    {{"merges", "Fragments merged", "fragments", 16},
     {"discards", "Samples discarded while visible", "samples", 8},
     {"surfaces", "Surfaces stored", "surfaces", 4},
     {"order_errors", "Surfaces out of order", "surfaces", 4}},
    layout,
    [](gpu::PassRecorder& recorder, const FrameSetup& setup) { record_streaming(recorder, setup); }};

}  // namespace subpixel::replay
