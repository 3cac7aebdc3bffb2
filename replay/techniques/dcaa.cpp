// Decoupled coverage anti-aliasing: a conservative z-prepass, then one ordered geometry pass that keeps up to S
// surfaces a pixel, each with a mask of up to 64 coverage samples and one plane; the resolve finds what each surface
// shows and lights it once. Wang, Wyman, He and Sen, "Decoupled Coverage Anti-Aliasing", High-Performance Graphics
// 2015.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <numbers>

#include "replay/frontend/fragment_lists.hpp"
#include "replay/techniques/dcaa_prepass.hpp"
#include "replay/techniques/dcaa_table.hpp"
#include "replay/techniques/dcaa_view.hpp"
#include "replay/techniques/deferred.hpp"

namespace subpixel::replay {
namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT, kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr VkImageUsageFlags kTarget =
    VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr std::uint32_t kMostAttachments = 8, kFewestAttachments = 3;

std::uint32_t whole(const FrameSetup& setup, std::string_view name) {
  return static_cast<std::uint32_t>(setup.number(name));
}

std::uint32_t normal_format(const FrameSetup& setup) {
  const std::string format = setup.choice("facet_normal");
  return format == "2x8"
             ? DCAA_NORMAL_2X8
             : (format == "3x8" ? DCAA_NORMAL_3X8 : (format == "3x32" ? DCAA_NORMAL_3X32 : DCAA_NORMAL_2X16));
}

// As in shaders/techniques/dcaa/state.glsl.
std::uint32_t state_quads(const FrameSetup& setup) {
  const std::uint32_t surface_words =
      (setup.samples == 64 ? 2 : 1) + (normal_format(setup) == DCAA_NORMAL_3X32 ? 3 : 1) + 3 +
      (whole(setup, "depth_bits") == 32 ? 1 : 0) + (setup.scene.features().has(FEATURE_EMISSIVE) ? 1 : 0);
  return (1 + whole(setup, "surfaces") * surface_words + 3) / 4;
}

CoverageTableSize table_size(const FrameSetup& setup) {
  return {whole(setup, "table_directions"), whole(setup, "table_distances")};
}

gpu::Constants dcaa_constants(const FrameSetup& setup) {
  std::uint32_t options = 0;
  if (setup.parameters.at("second_merge").get<bool>()) options |= DCAA_SECOND_MERGE;
  if (setup.parameters.at("keep_front").get<bool>()) options |= DCAA_KEEP_FRONT;
  if (setup.parameters.at("prepass").get<bool>()) options |= DCAA_PREPASS;
  if (setup.choice("coverage") == "lut") options |= DCAA_TABLE;
  if (setup.choice("merge_weight") == "shown") options |= DCAA_WEIGHT_SHOWN;
  const auto reach = static_cast<float>(setup.number("depth_reach"));
  const auto cosine = static_cast<float>(std::cos(setup.number("normal_angle")));
  return {
      {10, whole(setup, "surfaces")},    {11, std::bit_cast<std::uint32_t>(cosine)}, {12, options},
      {13, normal_format(setup)},        {14, whole(setup, "depth_bits")},           {15, table_size(setup).directions},
      {16, table_size(setup).distances}, {17, std::bit_cast<std::uint32_t>(reach)}};
}

void append(gpu::Constants& constants, const gpu::Constants& more) {
  constants.insert(constants.end(), more.begin(), more.end());
}

MemoryLayout layout(const FrameSetup& setup) {
  const double s = setup.number("surfaces"), n = setup.samples;
  const double depth = setup.number("depth_bits");
  const double facet =
      normal_format(setup) == DCAA_NORMAL_3X32 ? 96 : (normal_format(setup) == DCAA_NORMAL_2X16 ? 32 : 24);
  MemoryLayout memory;
  // Section 4.3 and figure 6: coverage 8 bytes, facet normal 4, and a G-buffer sample of 16 that its depth is part of.
  memory.paper = {{"coverage", n * s}, {"facet normal", 32 * s}, {"G-buffer samples", 128 * s}};
  memory.fitted = {{"coverage", n * s},
                   {"facet normal", facet * s},
                   {"depth", depth * s},
                   {"attributes", fitted_surface_bits(setup.scene.features()) * s},
                   {"count word", 32}};
  if (setup.parameters.at("prepass").get<bool>()) memory.fitted.push_back({"prepass planes", 256});
  return memory;
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

gpu::Buffer& table_buffer(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  const std::vector<std::uint64_t> table = coverage_table(table_size(setup), setup.samples);
  gpu::Buffer& buffer = recorder.buffer("dcaa coverage table", table.size() * sizeof(std::uint64_t));
  std::ranges::copy(table, buffer.as<std::uint64_t>().begin());
  return buffer;
}

gpu::Image& record_bound(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Buffer& table) {
  gpu::Image& bound = recorder.image(
      {"dcaa depth bound", kWords, setup.width, setup.height, 1, 2, VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  Frontend::GeometryPass geometry;
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "z-prepass";
  geometry.fragment_opaque = "techniques/dcaa/prepass.frag:OPAQUE";
  geometry.fragment_alpha = "techniques/dcaa/prepass.frag:ALPHA";
  pass.pipeline.constants = common_constants(setup);
  append(pass.pipeline.constants, dcaa_constants(setup));
  pass.pipeline.targets.ordered_read = true;
  pass.pipeline.targets.clear = true;
  pass.pipeline.targets.colours = {kWords, kWords};
  pass.colours = {{bound, 0}, {bound, 1}};
  pass.clear_colours = {{}, {}};
  pass.bindings = {gpu::reads(1, table)};
  setup.frontend.record_geometry(recorder, std::move(geometry));
  return bound;
}

Resources make_resources(gpu::PassRecorder& recorder, const FrameSetup& setup, bool in_buffer) {
  const std::uint32_t quads = state_quads(setup);
  Resources r;
  if (quads <= kMostAttachments && !in_buffer) {
    r.state = &recorder.image({"dcaa state", kWords, setup.width, setup.height, 1, std::max(quads, kFewestAttachments),
                               VK_SAMPLE_COUNT_1_BIT, kTarget, true});
  } else {
    r.words = &recorder.buffer("dcaa state", state_pixels(setup) * quads * 16);
    r.address = &recorder.buffer("dcaa state address", sizeof(VkDeviceAddress));
    r.address->as<VkDeviceAddress>()[0] = r.words->address();
  }
  r.table = &table_buffer(recorder, setup);
  r.view = &recorder.buffer("dcaa view", sizeof(gpu_types::DcaaView));
  r.view->as<gpu_types::DcaaView>()[0] = dcaa_view(setup.scene.constants().view_projection, setup.width, setup.height);
  return r;
}

void record_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const Resources& r) {
  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "merge";
  pass.pipeline.constants = common_constants(setup);
  append(pass.pipeline.constants, dcaa_constants(setup));
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
void record_list_merge(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists,
                       const Resources& r) {
  gpu::Buffer& kept = recorder.buffer("kept fragments", std::uint64_t{setup.width} * setup.height * 4);
  gpu::Buffer& surfaces = recorder.buffer("fragment surfaces", lists.count * 32);
  gpu::Buffer& surfaces_address = recorder.buffer("fragment surfaces address", sizeof(VkDeviceAddress));
  surfaces_address.as<VkDeviceAddress>()[0] = surfaces.address();

  ListedPass listed;
  listed.constants = common_constants(setup);
  append(listed.constants, dcaa_constants(setup));
  listed.bindings = {gpu::reads(1, *r.table), gpu::reads(2, *r.view), gpu::reads(3, surfaces_address)};
  listed.by_address = {&surfaces};
  const bool exact = setup.choice("coverage") == "exact";
  if (exact || setup.scene.features().has(FEATURE_ALPHA_TEST)) {
    listed.name = exact ? "masks" : "alpha";
    listed.shader = "techniques/dcaa/masks.comp";
    listed.alpha_only = !exact;
    record_listed_fragments(recorder, setup, lists, listed);
    listed.alpha_only = false;
  }

  struct {
    ListAddresses lists;
    std::uint64_t records, kept;
    std::uint32_t width, height;
  } const keep_push{lists.by_address(), setup.frontend.records().address(), kept.address(), setup.width, setup.height};
  gpu::ComputePass pass;
  pass.name = setup.parameters.at("prepass").get<bool>() ? "z-prepass" : "sort";
  pass.shader = "techniques/dcaa/keep.comp";
  pass.constants = setup.frontend.constants();
  append(pass.constants, dcaa_constants(setup));
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(1, *r.table)};
  pass.by_address = {lists.fragments, lists.numbers, lists.ends, &setup.frontend.records(), &kept};
  pass.push = gpu::PushConstants(keep_push);
  pass.groups = {(setup.width + 7) / 8, (setup.height + 7) / 8, 1};
  recorder.compute(pass);

  listed.name = "attributes";
  listed.shader = "techniques/dcaa/attributes.comp";
  record_listed_fragments(recorder, setup, lists, listed);

  struct {
    ListAddresses lists;
    std::uint64_t surfaces, kept, state;
    std::uint32_t width, height;
  } const push{lists.by_address(), surfaces.address(), kept.address(), r.words->address(), setup.width, setup.height};
  pass.name = "merge";
  pass.shader = "techniques/dcaa/merge_lists.comp";
  pass.bindings = {gpu::uniform(setup.scene.frame_constants), gpu::reads(2, *r.view)};
  pass.by_address = {lists.fragments, lists.numbers, lists.ends, &surfaces, &kept, r.words};
  pass.push = gpu::PushConstants(push);
  recorder.compute(pass);
}

void record_shading(gpu::PassRecorder& recorder, const FrameSetup& setup, const Resources& r) {
  const gpu::ImageDescription output{"output", kFloats, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                     kTarget,  false};
  setup.outputs.radiance = &recorder.image(output);
  setup.outputs.display = &recorder.image(output);
  gpu::RasterPass pass = lighting_pass(setup, "resolve and shade", "techniques/dcaa/shade.frag:" + r.variant());
  append(pass.pipeline.constants, dcaa_constants(setup));
  pass.pipeline.targets.colours = {kFloats, kFloats};
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}};
  pass.bindings.push_back(gpu::reads(2, *r.view));
  r.bind_state(pass);
  recorder.raster(std::move(pass));
}

// The maps are read off the state in a host step, so that they cost the technique no time, and once, since every run
// leaves the same state.
void record_maps(gpu::PassRecorder& recorder, const FrameSetup& setup, const Resources& r) {
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
  append(geometry.pass.pipeline.constants, dcaa_constants(setup));
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
  append(pass.pipeline.constants, dcaa_constants(setup));
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

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  const auto lists = record_fragment_lists(recorder, setup, "collect", ListedMasks::later);
  Resources resources = make_resources(recorder, setup, lists.has_value());
  if (lists) {
    record_list_merge(recorder, setup, *lists, resources);
  } else {
    if (setup.parameters.at("prepass").get<bool>()) resources.bound = &record_bound(recorder, setup, *resources.table);
    record_merge(recorder, setup, resources);
  }
  record_shading(recorder, setup, resources);
  record_maps(recorder, setup, resources);
}

Parameter integer(std::string_view name, std::string_view doc, double minimum, double maximum, int default_value,
                  std::vector<double> allowed = {}) {
  Parameter p;
  p.name = name;
  p.doc = doc;
  p.minimum = minimum;
  p.maximum = maximum;
  p.allowed = std::move(allowed);
  p.default_value = default_value;
  return p;
}

Parameter normal_angle_parameter() {
  Parameter p;
  p.name = "normal_angle";
  p.kind = ParameterKind::number;
  p.doc = "largest angle between the facet normals of fragments that merge";
  p.unit = "radians";
  p.minimum = 0;
  p.maximum = std::numbers::pi;
  p.default_value = std::numbers::pi / 16;
  return p;
}

Parameter depth_reach_parameter() {
  Parameter p;
  p.name = "depth_reach";
  p.kind = ParameterKind::number;
  p.doc = "how far from the pixel's centre the depth intervals of surfaces reach";
  p.unit = "pixels";
  p.minimum = 0;
  p.maximum = 8;
  p.default_value = 0.5;
  return p;
}

}  // namespace

gpu::Image& record_depth_bound(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  return record_bound(recorder, setup, table_buffer(recorder, setup));
}

extern const Technique kDcaa;

const Technique kDcaa{
    "dcaa",
    "Decoupled coverage anti-aliasing",
    "Wang, Wyman, He, Sen: Decoupled Coverage Anti-Aliasing. High-Performance Graphics 2015",
    {integer("surfaces", "surfaces kept for a pixel", 1, DCAA_MAX_SURFACES, 4), samples_parameter({16, 32, 64}, 64),
     choice_parameter("coverage", "masks come from a table of half-planes, or from exact edges", {"lut", "exact"}),
     integer("table_directions", "directions of edges in the table", 8, 4096, 256,
             {8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096}),
     integer("table_distances", "distances of edges from the pixel's centre in the table", 8, 1024, 128),
     normal_angle_parameter(), depth_reach_parameter(),
     choice_parameter("merge_weight", "merges weight by the samples covered, or by those the one in front leaves",
                      {"coverage", "shown"}),
     condition_parameter("second_merge", "the surface that has to go merges with one that overlaps it in depth"),
     condition_parameter("keep_front", "the front-most surface never has to go"),
     condition_parameter("prepass", "a conservative depth prepass rules out fragments"),
     choice_parameter("facet_normal", "components and bits of a surface's facet normal",
                      {"2x16", "2x8", "3x8", "3x32"}),
     integer("depth_bits", "bits of a surface's depth", 16, 32, 24, {16, 20, 24, 32}), order_parameter(),
     alpha_parameter(), resolve_parameter(), shading_parameter()},
    {{"surfaces", "Surfaces stored", "surfaces", 4},
     {"first_merges", "Fragments merged at the first attempt", "fragments", 16},
     {"second_merges", "Surfaces merged at the second attempt", "surfaces", 8},
     {"discards", "Surfaces discarded", "surfaces", 8},
     {"leaks", "Samples that show the sky though something covers them", "samples", 8},
     {"table_errors", "Sample decisions the table gets wrong", "samples", 8}},
    layout,
    record};

}  // namespace subpixel::replay
