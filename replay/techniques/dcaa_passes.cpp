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
#include "shaders/techniques/agaa/agaa_types.h"
#include "shaders/techniques/dcaa/dcaa_types.h"

namespace subpixel::replay {
namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT, kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr std::uint32_t kMostAttachments = 8, kFewestAttachments = 3;

// As in shaders/techniques/dcaa/state.glsl.
std::uint32_t state_quads(const FrameSetup& setup, const DcaaForm& form) {
  const std::uint32_t surface_words = (setup.samples == 64 ? 2 : 1) + (form.normal_format == DCAA_NORMAL_3X32 ? 3 : 1) +
                                      3 + (form.depth_bits == 32 ? 1 : 0) +
                                      (setup.scene.features().has(FEATURE_EMISSIVE) ? 1 : 0) +
                                      ((form.options & DCAA_SECOND_MOMENTS) != 0 ? 3 : 0);
  return (1 + form.surfaces * surface_words + 3) / 4;
}

gpu::Constants constants_of(const DcaaForm& form) {
  return {{10, form.surfaces},
          {11, std::bit_cast<std::uint32_t>(form.normal_cosine)},
          {12, form.options},
          {13, form.normal_format},
          {14, form.depth_bits},
          {15, form.table.directions},
          {16, form.table.distances},
          {17, std::bit_cast<std::uint32_t>(form.depth_reach)},
          {18, std::bit_cast<std::uint32_t>(form.inverse_length)}};
}

void append(gpu::Constants& constants, const gpu::Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

// What the passes share. The state lies in attachments up to 32 words a pixel, whose order the device promises; more in
// a buffer.
struct Resources {
  gpu::Image* state = nullptr;
  gpu::Buffer* words = nullptr;
  gpu::Buffer* address = nullptr;
  gpu::Image* bound = nullptr;
  gpu::Buffer* table = nullptr;
  gpu::Buffer* view = nullptr;

  std::string variant() const { return state ? "IMAGE" : "BUFFER"; }
  void bind_state(gpu::RasterPass& pass) const {
    if (state) {
      pass.bindings.push_back(gpu::samples(0, *state));
    } else {
      pass.bindings.push_back(gpu::reads(0, *address));
      pass.by_address.push_back(words);
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
  pass.pipeline.targets.colours = {kWords, kWords};
  pass.colours = {{bound, 0}, {bound, 1}};
  pass.clear_colours = {{}, {}};
  pass.bindings = {gpu::reads(1, table)};
  setup.frontend.record_geometry(recorder, std::move(geometry));
  return bound;
}

Resources make_resources(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form, bool in_buffer) {
  const std::uint32_t quads = state_quads(setup, form);
  Resources r;
  if (quads <= kMostAttachments && !in_buffer) {
    r.state = &recorder.image({"dcaa state", kWords, setup.width, setup.height, 1, std::max(quads, kFewestAttachments),
                               VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  } else {
    r.words = &recorder.buffer("dcaa state", state_pixels(setup) * quads * 16);
    r.address = &recorder.buffer("dcaa state address", sizeof(VkDeviceAddress));
    r.address->as<VkDeviceAddress>()[0] = r.words->address();
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
  pass.bindings = {gpu::reads(1, *r.table), gpu::reads(2, *r.view)};
  // Without a prepass the shader reads no bound, but declares it: the slot may not be empty.
  gpu::Image& bound =
      r.bound ? *r.bound : recorder.image({"no bound", kWords, 1, 1, 1, 1, VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  pass.bindings.push_back(gpu::samples(0, bound));
  if (r.state) {
    const std::uint32_t attachments = r.state->description().layers;
    geometry.fragment_opaque = fmt::format("techniques/dcaa/merge.frag:{}", attachments);
    pass.pipeline.targets.ordered_read = true;
    pass.pipeline.targets.clear = true;
    pass.pipeline.targets.colours.assign(attachments, kWords);
    for (std::uint32_t i = 0; i < attachments; ++i) pass.colours.emplace_back(*r.state, i);
    pass.clear_colours.assign(attachments, {});
  } else {
    geometry.fragment_opaque = std::string("techniques/dcaa/merge.frag:") + buffer_variant(recorder.device());
    recorder.fill("merge", *r.words, 0);
    pass.bindings.push_back(gpu::reads(0, *r.address));
    pass.by_address.push_back(r.words);
    pass.size = {setup.width, setup.height};
  }
  setup.frontend.record_geometry(recorder, std::move(geometry));
}

// The same state, prepass included, by passes over fragment lists.
void record_list_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const DcaaForm& form,
                       const FragmentLists& lists, const Resources& r) {
  gpu::Buffer& kept = recorder.buffer("kept fragments", std::uint64_t{setup.width} * setup.height * 4);
  gpu::Buffer& surfaces = recorder.buffer("fragment surfaces", lists.count * 32);
  gpu::Buffer& surfaces_address = recorder.buffer("fragment surfaces address", sizeof(VkDeviceAddress));
  surfaces_address.as<VkDeviceAddress>()[0] = surfaces.address();

  ListedPass listed;
  listed.constants = common_constants(setup);
  append(listed.constants, constants_of(form));
  listed.bindings = {gpu::reads(1, *r.table), gpu::reads(2, *r.view), gpu::reads(3, surfaces_address)};
  listed.writes(surfaces);
  const bool exact = (form.options & DCAA_TABLE) == 0;
  if (exact || setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    listed.name = exact ? "masks" : "alpha";
    listed.shader = "techniques/dcaa/masks.comp";
    listed.alpha_only = !exact;
    record_listed_fragments(recorder, setup, lists, listed);
    listed.alpha_only = false;
  }

  gpu::ComputePass pass;
  struct {
    gpu_types::ListAddresses lists;
    std::uint64_t records, kept;
    std::uint32_t width, height;
  } const keep_push{lists.writes(pass), setup.frontend.records().address(), kept.address(), setup.width, setup.height};
  pass.name = (form.options & DCAA_PREPASS) != 0 ? "z-prepass" : "sort";
  pass.shader = "techniques/dcaa/keep.comp";
  pass.constants = setup.frontend.constants();
  append(pass.constants, constants_of(form));
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(1, *r.table)};
  pass.by_address = {lists.fragments, lists.numbers, lists.ends, lists.bases, &setup.frontend.records(), &kept};
  pass.push = gpu::PushConstants(keep_push);
  pass.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};
  recorder.compute(pass);

  listed.name = "attributes";
  listed.shader = "techniques/dcaa/attributes.comp";
  record_listed_fragments(recorder, setup, lists, listed);

  struct {
    gpu_types::ListAddresses lists;
    std::uint64_t surfaces, kept, state;
    std::uint32_t width, height;
  } const push{lists.writes(pass), surfaces.address(), kept.address(), r.words->address(), setup.width, setup.height};
  pass.name = "merge";
  pass.shader = "techniques/dcaa/merge_lists.comp";
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(2, *r.view)};
  pass.by_address = {lists.fragments, lists.numbers, lists.ends, lists.bases, &surfaces, &kept, r.words};
  pass.push = gpu::PushConstants(push);
  recorder.compute(pass);
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
  if (lobes) pass.pipeline.constants.emplace_back(9, form.shadow_taps);
  if (lobes) pass.pipeline.constants.emplace_back(8, (form.options & DCAA_SECOND_MOMENTS) != 0 ? AGAA_SGGX : 0u);
  pass.pipeline.targets.colours = {kFloats, kFloats};
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  pass.bindings.push_back(gpu::reads(1, *r.table));  // declared with the masks' own functions, not read
  pass.bindings.push_back(gpu::reads(2, *r.view));
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
  geometry.pass.pipeline.targets.colours = {kWords};
  geometry.pass.clear_colours = {{}};
  geometry.pass.bindings = {gpu::reads(1, *r.table)};

  gpu::RasterPass pass;
  pass.name = "maps";
  pass.pipeline.vertex = "shade/fullscreen.vert";
  pass.pipeline.fragment = "techniques/dcaa/maps.frag:" + r.variant();
  pass.pipeline.constants = setup.frontend.constants();
  append(pass.pipeline.constants, constants_of(form));
  pass.pipeline.targets.colours.assign(maps.size(), VK_FORMAT_R32_UINT);
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
    pass.bindings.push_back(gpu::samples(1, found));
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
  const auto lists = record_fragment_lists(recorder, setup, "collect", ListedMasks::later);
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
