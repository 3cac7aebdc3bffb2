#include "replay/techniques/dcaa_passes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "replay/frontend/pixel_fragments.hpp"
#include "replay/techniques/dcaa_story.hpp"
#include "replay/techniques/dcaa_view.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/ordered_state.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

std::uint32_t state_quads(const FrameSetup& setup, const DcaaForm& form) {
  const std::uint32_t surface_words =
      DCAA_SURFACE_WORDS(setup.samples, setup.scene.features().bits, form.options, form.normal_format, form.depth_bits);
  return DCAA_STATE_QUADS(form.surfaces, surface_words);
}

gpu::Constants constants_of(const DcaaForm& form) {
  return {{DCAA_CONSTANT_SURFACES, form.surfaces},
          {DCAA_CONSTANT_COS_NORMAL_ANGLE, std::bit_cast<std::uint32_t>(form.normal_cosine)},
          {DCAA_CONSTANT_OPTIONS, form.options},
          {DCAA_CONSTANT_NORMAL_FORMAT, form.normal_format},
          {DCAA_CONSTANT_DEPTH_BITS, form.depth_bits},
          {DCAA_CONSTANT_TABLE_DIRECTIONS, form.table.directions},
          {DCAA_CONSTANT_TABLE_DISTANCES, form.table.distances},
          {DCAA_CONSTANT_DEPTH_REACH, std::bit_cast<std::uint32_t>(form.depth_reach)},
          {DCAA_CONSTANT_INVERSE_LENGTH, std::bit_cast<std::uint32_t>(form.inverse_length)}};
}

// What the passes share.
struct Resources {
  OrderedState state;
  gpu::Image* bound = nullptr;
  gpu::Buffer* table = nullptr;
  gpu::Buffer* view = nullptr;
};

gpu::Buffer& table_buffer(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form) {
  const std::vector<std::uint64_t> table = coverage_table(form.table, setup.samples);
  gpu::Buffer& buffer = recorder.buffer("dcaa coverage table", table.size() * sizeof(std::uint64_t));
  std::ranges::copy(table, buffer.as<std::uint64_t>().begin());
  return buffer;
}

gpu::Image& record_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form,
                         gpu::Buffer& table) {
  gpu::Image& bound = target_array(recorder, setup, "dcaa depth bound", VK_FORMAT_R32G32B32A32_UINT, 2);
  Frontend::GeometryPass geometry;
  geometry.pass.name = "z-prepass";
  geometry.fragment_opaque = "techniques/dcaa/prepass.frag:OPAQUE";
  geometry.fragment_alpha = "techniques/dcaa/prepass.frag:ALPHA";
  geometry.pass.pipeline.constants = common_constants(setup);
  gpu::append(geometry.pass.pipeline.constants, constants_of(form));
  geometry.pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, table)};
  attach_ordered(geometry.pass, bound);
  setup.frontend.record_geometry(recorder, std::move(geometry));
  return bound;
}

Resources make_resources(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, bool from_lists) {
  Resources r;
  r.state = make_ordered_state(recorder, setup, "dcaa state", state_quads(setup, form), from_lists);
  r.table = &table_buffer(recorder, setup, form);
  r.view = &recorder.buffer("dcaa view", sizeof(gpu_types::DcaaView));
  r.view->as<gpu_types::DcaaView>()[0] =
      dcaa_view(setup.scene.constants().view_projection, setup.width, setup.frame_height());
  r.view->as<gpu_types::DcaaView>()[0].ray0.w = static_cast<float>(setup.scene.constants().band.x);
  return r;
}

void record_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  Frontend::GeometryPass geometry;
  geometry.pass.name = "merge";
  geometry.pass.pipeline.constants = common_constants(setup);
  gpu::append(geometry.pass.pipeline.constants, constants_of(form));
  // Without a prepass the shader reads no bound, but declares it: the slot may not be empty.
  gpu::Image& bound = r.bound ? *r.bound
                              : recorder.image({.name = "no bound",
                                                .format = VK_FORMAT_R32G32B32A32_UINT,
                                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT,
                                                .array = true});
  geometry.pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table), gpu::reads(DCAA_SLOT_VIEW, *r.view),
                            gpu::samples(DCAA_SLOT_BOUND, bound)};
  record_ordered(recorder, setup, r.state, std::move(geometry), "techniques/dcaa/merge.frag");
}

// The same state, prepass included, by passes over fragment lists. `steps`: of a story, which the merge then tells.
void record_list_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form,
                       const FragmentLists& lists, const Resources& r, gpu::Buffer* steps = nullptr) {
  const ListedState listed(recorder, setup, lists, r.state, sizeof(gpu_types::DcaaListedSurface));
  ListedPass fragments;
  fragments.constants = common_constants(setup);
  gpu::append(fragments.constants, constants_of(form));
  fragments.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table), gpu::reads(DCAA_SLOT_VIEW, *r.view), listed.surfaces()};
  // Exact masks are long loops, and long lists are loops of many turns: then masks are made one an invocation.
  const bool masks_first = (form.options & DCAA_TABLE) == 0 || lists.parts > 1;
  DcaaForm listed_form = form;
  if (masks_first) listed_form.options |= DCAA_MASKS_MADE;
  gpu::ComputePass pixels;
  pixels.constants = constants_of(listed_form);
  pixels.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table), gpu::reads(DCAA_SLOT_VIEW, *r.view)};

  if (masks_first || setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    fragments.name = masks_first ? "masks" : "alpha";
    fragments.shader = "techniques/dcaa/masks.comp";
    fragments.alpha_only = !masks_first;
    record_listed_fragments(recorder, setup, lists, fragments);
    fragments.alpha_only = false;
  }
  pixels.name = (form.options & DCAA_PREPASS) != 0 ? "z-prepass" : "sort";
  pixels.shader = "techniques/dcaa/keep.comp";
  listed.record_keep(pixels);
  fragments.name = "attributes";
  fragments.shader = "techniques/dcaa/attributes.comp";
  record_listed_fragments(recorder, setup, lists, fragments);
  pixels.name = "merge";
  pixels.shader = "techniques/dcaa/merge_lists.comp";
  listed.record_merge(pixels);
  if (steps == nullptr) return;
  pixels.shader = "techniques/dcaa/story.comp";
  pixels.bindings.push_back(gpu::writes(DCAA_SLOT_STORY, *steps));
  listed.record_merge(pixels, 1);
}

gpu::RasterPass shading_pass(const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  const bool lobes = (form.options & DCAA_DISTRIBUTION) != 0;
  gpu::RasterPass pass = lighting_pass(setup, "resolve and shade",
                                       "techniques/dcaa/shade.frag:" + r.state.variant() + (lobes ? "_LOBES" : ""));
  gpu::append(pass.pipeline.constants, constants_of(form));
  gpu::append(pass.pipeline.constants, {{DCAA_CONSTANT_LEAST_SHOWN, form.least_shown}});
  if (lobes) {
    const bool moments = (form.options & DCAA_SECOND_MOMENTS) != 0;
    gpu::append(pass.pipeline.constants,
                {{AGAA_CONSTANT_SHADOW_TAPS, form.shadow_taps}, {AGAA_CONSTANT_OPTIONS, moments ? AGAA_SGGX : 0u}});
  }
  pass.bindings.push_back(gpu::reads(DCAA_SLOT_TABLE, *r.table));  // declared with the masks' own functions, not read
  pass.bindings.push_back(gpu::reads(DCAA_SLOT_VIEW, *r.view));
  r.state.bind(pass);
  return pass;
}

void record_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  gpu::RasterPass pass = shading_pass(setup, form, r);
  pass.colours = make_outputs(recorder, setup);
  recorder.raster(std::move(pass));
}

// The pixel's fragments, and no others, once more through the passes over lists.
void record_story(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form) {
  PixelStory& story = *setup.story;
  const FragmentLists lists = pixel_lists(recorder, setup, story.pixel(), story.fragments(), ListedMasks::later);
  const Resources own = make_resources(recorder, setup, form, true);
  gpu::Buffer& steps = story.record_log<gpu_types::DcaaStep>(recorder, "dcaa steps", lists.count);
  record_list_merge(recorder, setup, form, lists, own, &steps);
  gpu::RasterPass pass = shading_pass(setup, form, own);
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  const bool lobes = (form.options & DCAA_DISTRIBUTION) != 0;
  story.record_lighting(recorder, std::move(pass),
                        std::string("techniques/dcaa/shade.frag:") + (lobes ? "STORY_LOBES" : "STORY"));
  story.tell("steps", [&story, &steps, form, listed = lists.fragments] {
    return dcaa_steps(story, form, PixelStory::log_of<gpu_types::DcaaStep>(steps), listed->as<glm::uvec4>());
  });
  story.tell("surfaces",
             [&steps, form] { return dcaa_surfaces(form, PixelStory::log_of<gpu_types::DcaaStep>(steps)); });
}

void record_maps(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  gpu::RasterPass pass = fullscreen_pass(setup, "maps", "techniques/dcaa/maps.frag:" + r.state.variant());
  gpu::append(pass.pipeline.constants, constants_of(form));
  const std::vector<gpu::Attachment> images =
      make_maps(recorder, setup, {"surfaces", "first_merges", "second_merges", "discards", "leaks", "table_errors"});
  r.state.bind(pass);

  recorder.device().ledger().require("dcaa found", padded_pixels(setup) * 16 + 16);
  Frontend::GeometryPass geometry;
  geometry.pass.name = "examine";
  geometry.fragment_opaque = "techniques/dcaa/examine.frag:OPAQUE";
  geometry.fragment_alpha = "techniques/dcaa/examine.frag:ALPHA";
  geometry.pass.pipeline.constants = common_constants(setup);
  gpu::append(geometry.pass.pipeline.constants, constants_of(form));
  geometry.pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table)};
  recorder.host(once([setup, geometry, pass, images] {
    gpu::PassRecorder own(setup.frontend.device());
    gpu::Buffer& found = own.buffer("dcaa found", padded_pixels(setup) * 16);
    own.fill(geometry.pass.name, found, 0);
    gpu::AddressTable& address = own.address_table("dcaa found address", sizeof(VkDeviceAddress));
    address.set(address.of(found));
    Frontend::GeometryPass examine = geometry;
    examine.pass.size = {setup.width, setup.height};
    examine.rasterise_frame = true;
    examine.pass.bindings.push_back(gpu::writes(DCAA_SLOT_FOUND, address));
    setup.frontend.record_geometry(own, std::move(examine));
    for (std::uint32_t first = 0; first < images.size(); first += DCAA_MAPS_AT_A_TIME) {
      gpu::RasterPass maps = pass;
      maps.pipeline.constants.emplace_back(DCAA_CONSTANT_FIRST_MAP, first);
      maps.colours.assign(images.begin() + first, images.begin() + first + DCAA_MAPS_AT_A_TIME);
      maps.bindings.push_back(gpu::reads(DCAA_SLOT_FOUND, address));
      own.raster(std::move(maps));
    }
    own.run();
    std::uint64_t decisions = 0;
    const auto words = found.as<glm::uvec4>().first(std::size_t{setup.width} * setup.height);
    for (const glm::uvec4& pixel : words) decisions += pixel.z;
    setup.outputs.counters["table_decisions"] = decisions;
  }));
}

}  // namespace

gpu::Image& record_depth_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form) {
  return record_bound(recorder, setup, form, table_buffer(recorder, setup, form));
}

namespace field {

Field<DecoupledParameters> kept_surfaces() {
  return integer("surfaces", &DecoupledParameters::surfaces, {1, DCAA_MAX_SURFACES}, "surfaces kept for a pixel");
}

Field<DecoupledParameters> coverage_source() {
  return choice("coverage", &DecoupledParameters::coverage,
                "masks come from a table of half-planes, or from exact edges",
                {{"lut", DecoupledCoverage::table}, {"exact", DecoupledCoverage::exact}});
}

Field<DecoupledParameters> depth_reach() {
  return number("depth_reach", &DecoupledParameters::depth_reach, {0, 8},
                "how far from the pixel's centre the depth intervals of surfaces reach", "pixels");
}

}  // namespace field

DcaaForm common_form(const DecoupledParameters& parameters) {
  DcaaForm form;
  form.surfaces = parameters.surfaces;
  if (parameters.coverage == DecoupledCoverage::table) form.options |= DCAA_TABLE;
  form.normal_cosine = static_cast<float>(std::cos(parameters.normal_angle));
  form.depth_reach = static_cast<float>(parameters.depth_reach);
  return form;
}

std::string dcaa_whole_only(const FrameSetup& whole) {
  if (whole.lists) return "";
  return "its one ordered pass also reads the table where only a hull reaches, which the device rasterises a little "
         "differently in other rows";
}

std::vector<MapDescription> dcaa_maps() {
  return {{"surfaces", "Surfaces stored", "surfaces", 4},
          {"first_merges", "Fragments merged at the first attempt", "fragments", 16},
          {"second_merges", "Surfaces merged at the second attempt", "surfaces", 8},
          {"discards", "Surfaces discarded", "surfaces", 8},
          {"leaks", "Samples that show the sky though something covers them", "samples", 8},
          {"table_errors", "Sample decisions the table gets wrong", "samples", 8}};
}

void record_dcaa(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form) {
  setup.frontend.record_setup(recorder);
  const auto lists = record_measured_lists(recorder, setup, "collect");
  Resources resources = make_resources(recorder, setup, form, lists.has_value());
  if (lists) {
    record_list_merge(recorder, setup, form, *lists, resources);
  } else {
    if ((form.options & DCAA_PREPASS) != 0) resources.bound = &record_bound(recorder, setup, form, *resources.table);
    record_merge(recorder, setup, form, resources);
  }
  record_shading(recorder, setup, form, resources);
  record_maps(recorder, setup, form, resources);
  if (setup.story != nullptr) record_story(recorder, setup, form);
}

}  // namespace subpixel::replay
