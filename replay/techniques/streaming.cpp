// Streaming G-buffer compression: one ordered geometry pass keeps up to S surfaces a pixel, merging fragments of one
// feature and discarding what the array can't hold; the resolve finds each sample's surface and lights those that show.
// Kerzner and Salvi, "Streaming G-Buffer Compression for Multi-Sample Anti-Aliasing", High-Performance Graphics 2014.
#include "replay/techniques/streaming.hpp"

#include <bit>
#include <cmath>

#include "replay/frontend/pixel_fragments.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/streaming_story.hpp"
#include "shaders/techniques/streaming/streaming_interface.h"

namespace subpixel::replay {
namespace {

gpu::Constants streaming_constants(const StreamingSetup& setup) {
  const StreamingParameters& p = setup.parameters;
  std::uint32_t options = 0;
  if (p.merge_normals) options |= STREAM_MERGE_NORMALS;
  if (p.merge_depth) options |= STREAM_MERGE_DEPTH;
  if (p.merge_coverage) options |= STREAM_MERGE_COVERAGE;
  if (p.merge_weight == StreamingWeight::coverage) options |= STREAM_WEIGHT_COVERAGE;
  if (p.occlusion == StreamingOcclusion::depth_test) options |= STREAM_DEPTH_TESTED;
  if (p.depth_space == StreamingDepth::clip) options |= STREAM_CLIP_SPACE;
  // With the depth test of each sample the stored masks are what shows.
  if (p.discard == StreamingDiscard::resolved || p.occlusion == StreamingOcclusion::depth_test)
    options |= STREAM_DISCARD_RESOLVED;
  const auto cosine = static_cast<float>(std::cos(p.normal_angle));
  return {{STREAM_CONSTANT_SURFACES, p.surfaces},
          {STREAM_CONSTANT_COS_NORMAL_ANGLE, std::bit_cast<std::uint32_t>(cosine)},
          {STREAM_CONSTANT_OPTIONS, options}};
}

MemoryLayout layout(const StreamingSetup& setup) {
  const double n = setup.samples, s = setup.parameters.surfaces;
  // Depth 32, derivatives 2 x 16, two masks, albedo 32, normal 32; up to 16 samples the masks fit the paper's 20 bytes.
  const double masks = std::max(2 * n, 32.0);
  return {{"depth", 32 * n}, {"count word", 32}, {"surfaces", (32 + 32 + masks + 32 + 32) * s}};
}

void record_compression(gpu::PassRecorder& recorder, const StreamingSetup& setup, const OrderedState& state) {
  Frontend::GeometryPass geometry;
  geometry.pass.name = "compress";
  geometry.pass.pipeline.constants = common_constants(setup);
  gpu::append(geometry.pass.pipeline.constants, streaming_constants(setup));
  record_ordered(recorder, setup, state, std::move(geometry), "techniques/streaming/compress.frag");
}

// The same state by passes over fragment lists. `steps`: of a story, which the merge then tells.
void record_list_compression(gpu::PassRecorder& recorder, const StreamingSetup& setup, const FragmentLists& lists,
                             const OrderedState& state, gpu::Buffer* steps = nullptr) {
  const ListedState listed(recorder, setup, lists, state, sizeof(gpu_types::StreamListedSurface));
  ListedPass fragments;
  fragments.constants = common_constants(setup);
  gpu::append(fragments.constants, streaming_constants(setup));
  gpu::ComputePass pixels;
  pixels.constants = streaming_constants(setup);

  if (setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    fragments.name = "alpha";
    fragments.shader = "techniques/streaming/alpha.comp";
    fragments.alpha_only = true;
    record_listed_fragments(recorder, setup, lists, fragments);
    fragments.alpha_only = false;
  }
  pixels.name = "depth test";
  pixels.shader = "techniques/streaming/depth_test.comp";
  listed.record_keep(pixels);
  fragments.name = "attributes";
  fragments.shader = "techniques/streaming/attributes.comp";
  fragments.bindings = {listed.surfaces()};
  record_listed_fragments(recorder, setup, lists, fragments);
  pixels.name = "merge";
  pixels.shader = "techniques/streaming/merge.comp";
  listed.record_merge(pixels);
  if (steps == nullptr) return;
  pixels.shader = "techniques/streaming/story.comp";
  pixels.bindings = {gpu::writes(STREAM_SLOT_STORY, *steps)};
  listed.record_merge(pixels, 1);
}

gpu::RasterPass shading_pass(const StreamingSetup& setup, const OrderedState& state) {
  gpu::RasterPass pass = lighting_pass(setup, "shade", "techniques/streaming/shade.frag:" + state.variant());
  gpu::append(pass.pipeline.constants, streaming_constants(setup));
  state.bind(pass);
  return pass;
}

void record_shading(gpu::PassRecorder& recorder, const StreamingSetup& setup, const OrderedState& state) {
  gpu::RasterPass pass = shading_pass(setup, state);
  pass.colours = make_outputs(recorder, setup);
  recorder.raster(std::move(pass));
}

// The pixel's fragments, and no others, once more through the passes over lists.
void record_story(gpu::PassRecorder& recorder, const StreamingSetup& setup) {
  PixelStory& story = *setup.story;
  const FragmentLists lists = pixel_lists(recorder, setup, story.pixel(), story.fragments(), ListedMasks::collected);
  const std::uint32_t quads = STREAM_STATE_QUADS(setup.samples, setup.scene.features().bits, setup.parameters.surfaces);
  const OrderedState state = make_ordered_state(recorder, setup, "streaming story", quads, true);
  gpu::Buffer& steps = story.record_log<gpu_types::StreamStep>(recorder, "streaming steps", lists.count);
  record_list_compression(recorder, setup, lists, state, &steps);
  gpu::RasterPass pass = shading_pass(setup, state);
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  story.record_lighting(recorder, std::move(pass), "techniques/streaming/shade.frag:STORY");
  story.tell("steps", [&story, &steps, parameters = setup.parameters] {
    return streaming_steps(story, parameters, PixelStory::log_of<gpu_types::StreamStep>(steps));
  });
  // Of a flagged pixel that shows anything, what shows nothing counts for nothing.
  story.amend([](nlohmann::json& told) {
    std::uint32_t lit = 0;
    for (const nlohmann::json& execution : told["executions"]) lit += execution["weight"].get<std::uint32_t>();
    for (const nlohmann::json& step : told["steps"])
      if (step.value("flagged", false) && lit > 0) told["left_out"] = told["samples"].get<std::uint32_t>() - lit;
  });
  story.tell("surfaces", [&steps, parameters = setup.parameters] {
    return streaming_surfaces(parameters, PixelStory::log_of<gpu_types::StreamStep>(steps));
  });
}

void record_maps(gpu::PassRecorder& recorder, const StreamingSetup& setup, const OrderedState& state) {
  gpu::RasterPass pass = fullscreen_pass(setup, "maps", "techniques/streaming/maps.frag:" + state.variant());
  gpu::append(pass.pipeline.constants, streaming_constants(setup));
  pass.colours = state.entries == nullptr
                     ? make_maps(recorder, setup, {"merges", "discards", "surfaces", "order_errors"})
                     : make_maps(recorder, setup,
                                 {"merges", "discards", "surfaces", "order_errors", "words_loaded", "words_stored"});
  state.bind(pass);
  recorder.host(once(run_pass(recorder.device(), std::move(pass))));
}

}  // namespace

OrderedState record_streaming(gpu::PassRecorder& recorder, const StreamingSetup& setup) {
  setup.frontend.record_setup(recorder);
  const auto lists = record_measured_lists(recorder, setup, "collect");
  const std::uint32_t features = setup.scene.features().bits, surfaces = setup.parameters.surfaces;
  const std::uint32_t quads =
      lists ? STREAM_STATE_QUADS(setup.samples, features, surfaces) : STREAM_HEAD_QUADS(setup.samples);
  // Entries lie in a buffer; where an interlock orders those, the rest does too.
  const bool in_buffer = lists.has_value() || recorder.device().info().pixel_interlock;
  OrderedState state = make_ordered_state(recorder, setup, "streaming state", quads, in_buffer);
  if (lists) {
    record_list_compression(recorder, setup, *lists, state);
  } else {
    add_entries(recorder, setup, state, "streaming surfaces", surfaces * STREAM_SURFACE_WORDS(setup.samples, features));
    record_compression(recorder, setup, state);
  }
  record_shading(recorder, setup, state);
  record_maps(recorder, setup, state);
  if (setup.story != nullptr) record_story(recorder, setup);
  return state;
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
               field::choice(
                   "discard", &StreamingParameters::discard,
                   "which surface has to go: the one with the fewest samples that nothing nearer covers, as in the "
                   "authors' code, or with the smallest depth-resolved mask, as the text can be read",
                   {{"uncovered", StreamingDiscard::uncovered}, {"resolved", StreamingDiscard::resolved}}),
               field::choice("depth_space", &StreamingParameters::depth_space,
                             "surfaces keep depth and derivatives along the view, or of the depth buffer",
                             {{"view", StreamingDepth::view}, {"clip", StreamingDepth::clip}}),
               field::order(), field::alpha(), field::resolve(), field::shading()},
    .maps = {{"merges", "Fragments merged", "fragments", 16},
             {"discards", "Samples discarded while visible", "samples", 8},
             {"surfaces", "Surfaces stored", "surfaces", 4},
             {"order_errors", "Surfaces out of order", "surfaces", 4},
             {"words_loaded", "Words of surfaces loaded by the ordered pass", "words", 256},
             {"words_stored", "Words of surfaces stored by the ordered pass", "words", 128}},
    .layout = layout,
    .record = [](gpu::PassRecorder& recorder, const StreamingSetup& setup) { record_streaming(recorder, setup); },
    .lists = ListedMasks::collected,
};

}  // namespace subpixel::replay
