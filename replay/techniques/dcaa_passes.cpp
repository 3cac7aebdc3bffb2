#include "replay/techniques/dcaa_passes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/dcaa_view.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/dcaa/dcaa_interface.h"

namespace subpixel::replay {
namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT, kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;

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

void append(gpu::Constants& constants, const gpu::Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

// What the passes share. The state lies in attachments up to 32 words a pixel, whose order the device promises; more in
// a buffer.
struct Resources {
  gpu::Image* state = nullptr;
  gpu::Buffer* words = nullptr;
  gpu::AddressTable* address = nullptr;
  gpu::Image* bound = nullptr;
  gpu::Buffer* table = nullptr;
  gpu::Buffer* view = nullptr;

  std::string variant() const { return state ? "IMAGE" : "BUFFER"; }
  void bind_state(gpu::RasterPass& pass) const {
    if (state) {
      pass.bindings.push_back(gpu::samples(ORDERED_SLOT_ATTACHMENTS, *state));
    } else {
      pass.bindings.push_back(gpu::reads(ORDERED_SLOT_ADDRESS, *address));
    }
  }
};

gpu::Buffer& table_buffer(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form) {
  const std::vector<std::uint64_t> table = coverage_table(form.table, setup.samples);
  gpu::Buffer& buffer = recorder.buffer("dcaa coverage table", table.size() * sizeof(std::uint64_t));
  std::ranges::copy(table, buffer.as<std::uint64_t>().begin());
  return buffer;
}

gpu::Image& record_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form,
                         gpu::Buffer& table) {
  gpu::Image& bound = recorder.image(
      {"dcaa depth bound", kWords, setup.width, setup.height, 1, 2, VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  Frontend::GeometryPass geometry;
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "z-prepass";
  geometry.fragment_opaque = "techniques/dcaa/prepass.frag:OPAQUE";
  geometry.fragment_alpha = "techniques/dcaa/prepass.frag:ALPHA";
  pass.pipeline.constants = common_constants(setup);
  append(pass.pipeline.constants, constants_of(form));
  pass.pipeline.targets.ordered_read = true;
  pass.pipeline.targets.clear = true;
  pass.colours = {{bound, 0}, {bound, 1}};
  pass.clear_colours = {{}, {}};
  pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, table)};
  setup.frontend.record_geometry(recorder, std::move(geometry));
  return bound;
}

Resources make_resources(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, bool in_buffer) {
  const std::uint32_t quads = state_quads(setup, form);
  Resources r;
  if (quads <= ORDERED_MOST_ATTACHMENTS && !in_buffer) {
    r.state = &recorder.image({"dcaa state", kWords, setup.width, setup.height, 1,
                               std::max<std::uint32_t>(quads, ORDERED_FEWEST_ATTACHMENTS), VK_SAMPLE_COUNT_1_BIT,
                               kTarget, true});
  } else {
    r.words = &recorder.buffer("dcaa state", state_pixels(setup) * quads * 16);
    r.address = &recorder.address_table("dcaa state address", sizeof(VkDeviceAddress));
    r.address->set(r.address->of(*r.words));
  }
  r.table = &table_buffer(recorder, setup, form);
  r.view = &recorder.buffer("dcaa view", sizeof(gpu_types::DcaaView));
  r.view->as<gpu_types::DcaaView>()[0] = dcaa_view(setup.scene.constants().view_projection, setup.width, setup.height);
  return r;
}

void record_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "merge";
  pass.pipeline.constants = common_constants(setup);
  append(pass.pipeline.constants, constants_of(form));
  pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table), gpu::reads(DCAA_SLOT_VIEW, *r.view)};
  // Without a prepass the shader reads no bound, but declares it: the slot may not be empty.
  gpu::Image& bound =
      r.bound ? *r.bound : recorder.image({"no bound", kWords, 1, 1, 1, 1, VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  pass.bindings.push_back(gpu::samples(DCAA_SLOT_BOUND, bound));
  if (r.state) {
    const std::uint32_t attachments = r.state->description().layers;
    geometry.fragment_opaque = fmt::format("techniques/dcaa/merge.frag:{}", attachments);
    pass.pipeline.targets.ordered_read = true;
    pass.pipeline.targets.clear = true;
    for (std::uint32_t i = 0; i < attachments; ++i) pass.colours.emplace_back(*r.state, i);
    pass.clear_colours.assign(attachments, {});
  } else {
    geometry.fragment_opaque = std::string("techniques/dcaa/merge.frag:") + buffer_variant(recorder.device());
    recorder.fill("merge", *r.words, 0);
    pass.bindings.push_back(gpu::writes(ORDERED_SLOT_ADDRESS, *r.address));
    pass.size = {setup.width, setup.height};
  }
  setup.frontend.record_geometry(recorder, std::move(geometry));
}

// The same state, prepass included, by passes over fragment lists.
void record_list_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form,
                       const FragmentLists& lists, const Resources& r) {
  gpu::Buffer& kept = recorder.buffer("kept fragments", std::uint64_t{setup.width} * setup.height * 4);
  gpu::Buffer& surfaces = recorder.buffer("fragment surfaces", lists.count * sizeof(gpu_types::DcaaListedSurface));
  gpu::AddressTable& surfaces_address = recorder.address_table("fragment surfaces address", sizeof(VkDeviceAddress));
  surfaces_address.set(surfaces_address.of(surfaces));

  ListedPass listed;
  listed.constants = common_constants(setup);
  append(listed.constants, constants_of(form));
  listed.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table), gpu::reads(DCAA_SLOT_VIEW, *r.view),
                     gpu::writes(DCAA_SLOT_SURFACES, surfaces_address)};
  const bool exact = (form.options & DCAA_TABLE) == 0;
  if (exact || setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    listed.name = exact ? "masks" : "alpha";
    listed.shader = "techniques/dcaa/masks.comp";
    listed.alpha_only = !exact;
    record_listed_fragments(recorder, setup, lists, listed);
    listed.alpha_only = false;
  }

  gpu::ComputePass by_pixel;
  by_pixel.constants = setup.frontend.constants();
  append(by_pixel.constants, constants_of(form));
  by_pixel.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(DCAA_SLOT_TABLE, *r.table),
                       gpu::reads(DCAA_SLOT_VIEW, *r.view)};
  by_pixel.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};

  gpu::ComputePass keep = by_pixel;
  keep.name = (form.options & DCAA_PREPASS) != 0 ? "z-prepass" : "sort";
  keep.shader = "techniques/dcaa/keep.comp";
  const gpu_types::DcaaKeepPush keep_push{.lists = lists.writes(keep),
                                          .records = keep.reads(setup.frontend.records()),
                                          .kept = keep.writes(kept),
                                          .width = setup.width,
                                          .height = setup.height};
  keep.push = gpu::PushConstants(keep_push);
  recorder.compute(std::move(keep));

  listed.name = "attributes";
  listed.shader = "techniques/dcaa/attributes.comp";
  record_listed_fragments(recorder, setup, lists, listed);

  gpu::ComputePass merge = by_pixel;
  merge.name = "merge";
  merge.shader = "techniques/dcaa/merge_lists.comp";
  const gpu_types::DcaaMergePush merge_push{.lists = lists.reads(merge),
                                            .surfaces = merge.reads(surfaces),
                                            .kept = merge.reads(kept),
                                            .state = merge.writes(*r.words),
                                            .width = setup.width,
                                            .height = setup.height};
  merge.push = gpu::PushConstants(merge_push);
  recorder.compute(std::move(merge));
}

void record_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  const gpu::ImageDescription output{"output", kFloats, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                     kTarget,  false};
  setup.outputs.radiance = &recorder.image(output);
  setup.outputs.display = &recorder.image(output);
  const bool lobes = (form.options & DCAA_DISTRIBUTION) != 0;
  gpu::RasterPass pass =
      lighting_pass(setup, "resolve and shade", "techniques/dcaa/shade.frag:" + r.variant() + (lobes ? "_LOBES" : ""));
  append(pass.pipeline.constants, constants_of(form));
  if (lobes) {
    const bool moments = (form.options & DCAA_SECOND_MOMENTS) != 0;
    append(pass.pipeline.constants,
           {{AGAA_CONSTANT_SHADOW_TAPS, form.shadow_taps}, {AGAA_CONSTANT_OPTIONS, moments ? AGAA_SGGX : 0u}});
  }
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  pass.bindings.push_back(gpu::reads(DCAA_SLOT_TABLE, *r.table));  // declared with the masks' own functions, not read
  pass.bindings.push_back(gpu::reads(DCAA_SLOT_VIEW, *r.view));
  r.bind_state(pass);
  recorder.raster(std::move(pass));
}

// The maps are read off the state in a host step, so that they cost the technique no time, and once, since every run
// leaves the same state.
void record_maps(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, const Resources& r) {
  std::vector<gpu::Image*> maps;
  for (const char* name : {"surfaces", "first_merges", "second_merges", "discards", "leaks", "table_errors"}) {
    maps.push_back(&map_image(recorder, setup, name));
    setup.outputs.maps.emplace_back(name, maps.back());
  }
  Frontend::GeometryPass geometry;
  geometry.pass.name = "examine";
  geometry.fragment_opaque = "techniques/dcaa/examine.frag:OPAQUE";
  geometry.fragment_alpha = "techniques/dcaa/examine.frag:ALPHA";
  geometry.pass.pipeline.constants = common_constants(setup);
  append(geometry.pass.pipeline.constants, constants_of(form));
  geometry.pass.pipeline.targets.ordered_read = true;
  geometry.pass.pipeline.targets.clear = true;
  geometry.pass.clear_colours = {{}};
  geometry.pass.bindings = {gpu::reads(DCAA_SLOT_TABLE, *r.table)};

  gpu::RasterPass pass;
  pass.name = "maps";
  pass.pipeline.vertex = "shade/fullscreen.vert";
  pass.pipeline.fragment = "techniques/dcaa/maps.frag:" + r.variant();
  pass.pipeline.constants = setup.frontend.constants();
  append(pass.pipeline.constants, constants_of(form));
  for (gpu::Image* map : maps) pass.colours.emplace_back(*map);
  pass.bindings = {gpu::uniform(setup.scene.frame_constants)};
  r.bind_state(pass);
  recorder.host([&device = recorder.device(), &frontend = setup.frontend, &outputs = setup.outputs,
                 size = std::array{setup.width, setup.height}, geometry = std::move(geometry), pass = std::move(pass),
                 done = false]() mutable {
    if (done) return;
    gpu::PassRecorder own(device);
    gpu::Image& found = own.image({"dcaa found", kWords, size[0], size[1], 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                   kTarget | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, false});
    geometry.pass.colours = {{found}};
    frontend.record_geometry(own, geometry);
    pass.bindings.push_back(gpu::samples(DCAA_SLOT_FOUND, found));
    own.raster(pass);
    own.run();
    const auto bytes = gpu::download(device, found);
    std::uint64_t decisions = 0;
    for (std::size_t texel = 0; texel < bytes.size(); texel += 16) {
      std::uint32_t here = 0;
      std::memcpy(&here, bytes.data() + texel + 8, sizeof(here));
      decisions += here;
    }
    outputs.counters["table_decisions"] = decisions;
    done = true;
  });
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
}

}  // namespace subpixel::replay
