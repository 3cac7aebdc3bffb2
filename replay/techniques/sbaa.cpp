// Surface-based anti-aliasing: Salvi and Vidimce 2012, "Surface based anti-aliasing", as the streaming, aggregate and
// decoupled-coverage papers describe it. Visibility with n samples says which surfaces a pixel shows; a second geometry
// pass stores one G-buffer sample for each of the S largest, and only these are shaded.
//
// What the first pass would store for a sample is found through the visibility buffer: its depth, 8 bits of hash of its
// triangle's number (two triangles of one hash in a pixel are one surface, as they are for the technique) and the
// triangle's face normal, which a compute pass works out once for each triangle.
#include <cmath>
#include <numbers>

#include "replay/frontend/visibility.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/frontend/frontend_types.h"

namespace subpixel::replay {
namespace {

enum class Mode { merge, id };

struct SbaaParameters : CommonParameters {
  std::uint32_t surfaces = 4;
  Mode mode = Mode::merge;
  double normal_angle = std::numbers::pi / 4;
};
using Setup = SetupFor<SbaaParameters>;

bool merges(const Setup& setup) {
  return setup.parameters.mode == Mode::merge;
}

MemoryLayout layout(const Setup& setup) {
  const double n = setup.samples, s = setup.parameters.surfaces;
  MemoryLayout memory;
  // Aggregate paper, section 5.4: a byte of primitive number a sample, 2 bytes of surface description a surface.
  memory.paper = {{"depth", 32 * n}, {"primitive hash", 8 * n}, {"G-buffer samples", 128 * s}, {"surfaces", 16 * s}};
  memory.fitted = {{"depth", 32 * n},
                   {"primitive hash", 8 * n},
                   {"normals", merges(setup) ? 16 * n : 0},
                   {"G-buffer samples", fitted_surface_bits(setup.scene.features()) * s},
                   {"surfaces", 16 * s}};
  return memory;
}

// A face normal and a depth slope for each triangle record: 8 bytes.
gpu::Buffer& record_faces(gpu::PassRecorder& recorder, const Setup& setup) {
  Frontend& frontend = setup.frontend;
  GpuScene& scene = setup.scene;
  gpu::Buffer& faces =
      recorder.buffer("triangle faces", frontend.records().bytes() / sizeof(gpu_types::TriangleRecord) * 8);
  constexpr std::uint32_t kRow = 1024;  // workgroups of 64 in x
  const auto groups = static_cast<std::uint32_t>((frontend.hull_triangles() + 63) / 64);
  struct {
    std::uint64_t hulls, records, positions, indices, instances, faces;
    std::uint32_t hull_triangles, row;
  } const push{frontend.hull_indices().address(),
               frontend.records().address(),
               scene.positions.address(),
               scene.indices.address(),
               scene.instances.address(),
               faces.address(),
               static_cast<std::uint32_t>(frontend.hull_triangles()),
               64 * kRow};
  gpu::ComputePass pass;
  pass.name = "normals";
  pass.shader = "techniques/sbaa/triangles.comp";
  pass.constants = frontend.constants();
  pass.bindings = {gpu::uniform(scene.frame_constants)};
  pass.by_address = {&frontend.hull_indices(), &frontend.records(), &scene.positions,
                     &scene.indices,           &scene.instances,    &faces};
  pass.push = gpu::PushConstants(push);
  pass.groups = {std::min(groups, kRow), (groups + kRow - 1) / kRow, 1};
  recorder.compute(std::move(pass));
  return faces;
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const std::uint32_t kept = setup.parameters.surfaces;
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, setup);

  gpu::Buffer& faces = record_faces(recorder, setup);
  constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
  gpu::Image& stored = recorder.image({"surfaces", kWords, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, false});
  gpu::Image& count = map_image(recorder, setup, "surfaces");
  gpu::Image& dropped = map_image(recorder, setup, "dropped");
  setup.outputs.maps.emplace_back("surfaces", &count);
  setup.outputs.maps.emplace_back("dropped", &dropped);
  gpu::RasterPass analyse = lighting_pass(setup, "analyse", "techniques/sbaa/analyse.frag");
  analyse.pipeline.constants.emplace_back(7, kept);
  analyse.pipeline.constants.emplace_back(8, merges(setup) ? 1 : 0);
  analyse.pipeline.targets.colours = {kWords, count.description().format, dropped.description().format};
  analyse.pipeline.targets.clear = true;
  analyse.colours = {{stored}, {count}, {dropped}};
  analyse.clear_colours = {{}, {}, {}};
  analyse.bindings.push_back(gpu::samples(0, visibility));
  analyse.by_address = {&faces};
  struct {
    std::uint64_t faces;
    float cosine;
  } const push{faces.address(), static_cast<float>(std::cos(setup.parameters.normal_angle))};
  analyse.push = gpu::PushConstants(push);
  recorder.raster(std::move(analyse));

  const bool narrow = narrow_samples(setup);
  gpu::Image& gbuffer =
      recorder.image({"G-buffer", narrow ? VK_FORMAT_R16G16B16A16_UINT : kWords, setup.width, setup.height, 1, kept,
                      VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, true});
  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  geometry.fragment_opaque = narrow ? "techniques/sbaa/surfaces.frag:NARROW" : "techniques/sbaa/surfaces.frag:WIDE";
  geometry.pass.name = "surfaces";
  geometry.pass.size = {setup.width, setup.height};
  geometry.pass.pipeline.constants = common_constants(setup);
  geometry.pass.pipeline.constants.emplace_back(7, kept);
  geometry.pass.bindings = {gpu::samples(0, visibility), gpu::samples(1, stored), gpu::image_writes(0, gbuffer)};
  setup.frontend.record_geometry(recorder, std::move(geometry));

  gpu::Image& sum = sum_image(recorder, setup);
  gpu::RasterPass shade = lighting_pass(setup, "shade", "techniques/sbaa/shade.frag");
  shade.pipeline.constants.emplace_back(7, kept);
  shade.pipeline.targets.colours = {sum.description().format};
  shade.pipeline.targets.clear = true;
  shade.colours = {{sum}};
  shade.clear_colours = {{}};
  shade.bindings.insert(shade.bindings.end(), {gpu::samples(0, visibility), gpu::samples(1, stored),
                                               gpu::samples(2, gbuffer), gpu::samples(3, dropped)});
  recorder.raster(std::move(shade));
  record_resolve(recorder, setup, sum);
}

}  // namespace

extern const Technique kSbaa;

const Technique kSbaa = TechniqueOf<SbaaParameters>{
    .name = "sbaa",
    .title = "Surface-based anti-aliasing",
    .paper = "Salvi, Vidimce: Surface based anti-aliasing. I3D 2012",
    .fields =
        {field::samples({4, 8, 16, 32}),
         field::integer("surfaces", &SbaaParameters::surfaces, {1, 8}, "G-buffer samples kept for each pixel",
                        "surfaces"),
         field::choice(
             "mode", &SbaaParameters::mode,
             "id: a surface is a primitive; merge: primitives with aligned normals and overlapping depths are one",
             {{"merge", Mode::merge}, {"id", Mode::id}}),
         field::angle("normal_angle", &SbaaParameters::normal_angle, "normals are aligned below this angle"),
         field::alpha(), field::resolve(), field::shading()},
    .maps = {{"surfaces", "Surfaces kept", "per pixel", 8}, {"dropped", "Samples dropped", "per pixel"}},
    .layout = layout,
    .record = record,
};

}  // namespace subpixel::replay
