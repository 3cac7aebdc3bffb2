// Surface-based anti-aliasing: Salvi and Vidimce 2012, "Surface based anti-aliasing", as the streaming, aggregate and
// decoupled-coverage papers describe it. Visibility with n samples says which surfaces a pixel shows; a second geometry
// pass stores one G-buffer sample for each of the S largest, and only these are shaded.
//
// What the first pass would store for a sample is found through the visibility buffer: its depth, 8 bits of hash of its
// triangle's number (two triangles of one hash in a pixel are one surface, as they are for the technique) and the
// triangle's face normal, which a compute pass works out once for each triangle.
#include <cmath>
#include <numbers>

#include "replay/techniques/deferred.hpp"
#include "replay/techniques/sbaa_story.hpp"
#include "shaders/techniques/sbaa/sbaa_interface.h"

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
  // Aggregate paper, section 5.4 and figure 14, for merging: depth and the 2-byte normal of its figure 7 a sample, as
  // its own first pass stores them; a byte of primitive number a sample and 2 bytes of description a surface on top.
  MemoryLayout memory{
      {"depth", 32 * n}, {"primitive hash", 8 * n}, {"G-buffer samples", 128 * s}, {"surfaces", 16 * s}};
  if (merges(setup)) memory.push_back({"normals", 16 * n});
  return memory;
}

// A face normal and a depth slope for each triangle record: 8 bytes.
gpu::Buffer& record_faces(gpu::PassRecorder& recorder, const Setup& setup) {
  Frontend& frontend = setup.frontend;
  GpuScene& scene = setup.scene;
  gpu::Buffer& faces = recorder.buffer(
      "triangle faces", frontend.records().bytes() / sizeof(gpu_types::TriangleRecord) * SBAA_FACE_BYTES);
  constexpr std::uint32_t kRow = 1024;  // workgroups of 64 in x
  const auto groups = static_cast<std::uint32_t>((frontend.hull_triangles() + 63) / 64);
  gpu::ComputePass pass;
  pass.name = "normals";
  pass.shader = "techniques/sbaa/triangles.comp";
  pass.constants = frontend.constants();
  pass.bindings = {gpu::uniform(scene.frame_constants)};
  pass.push = gpu::PushConstants(
      gpu_types::SbaaTrianglesPush{.hulls = pass.reads(frontend.hull_indices()),
                                   .records = pass.reads(frontend.records()),
                                   .positions = pass.reads(scene.positions),
                                   .indices = pass.reads(scene.indices),
                                   .instances = pass.reads(scene.instances),
                                   .faces = pass.writes(faces),
                                   .hull_triangles = static_cast<std::uint32_t>(frontend.hull_triangles()),
                                   .row = 64 * kRow});
  pass.groups = {std::min(groups, kRow), (groups + kRow - 1) / kRow, 1};
  recorder.compute(std::move(pass));
  return faces;
}

// The analysis and the lighting of the story's pixel once more, with a log each.
void record_story(gpu::PassRecorder& recorder, const Setup& setup, const gpu::RasterPass& analyse,
                  gpu::RasterPass shade) {
  PixelStory& story = *setup.story;
  gpu::Buffer& steps = story.record_log<gpu_types::SbaaStep>(recorder, "sbaa steps", setup.samples);
  gpu::Buffer& kept = story.record_log<gpu_types::SbaaKept>(recorder, "sbaa surfaces", setup.parameters.surfaces);
  story.record_again(recorder, analyse, "techniques/sbaa/analyse.frag:STORY", gpu::writes(SBAA_SLOT_STORY, steps));
  shade.bindings.push_back(gpu::writes(SBAA_SLOT_STORY, kept));
  story.record_lighting(recorder, std::move(shade), "techniques/sbaa/shade.frag:STORY");
  const SbaaForm form{setup.samples, setup.parameters.surfaces, merges(setup),
                      static_cast<float>(std::cos(setup.parameters.normal_angle))};
  const auto told = [&story, &steps, &kept, form](auto tell) {
    return tell(story, form, PixelStory::log_of<gpu_types::SbaaStep>(steps),
                PixelStory::log_of<gpu_types::SbaaKept>(kept));
  };
  story.tell("steps", [told] { return told(sbaa_steps); });
  story.tell("surfaces", [told] { return told(sbaa_surfaces); });
  story.amend(light_surfaces);
  story.amend([](nlohmann::json& document) { document["left_out"] = document["maps"]["dropped"]; });
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const std::uint32_t kept = setup.parameters.surfaces;
  const VisibleFragments visible = record_visible(recorder, setup);
  gpu::Image& visibility = *visible.visibility;

  gpu::Buffer& faces = record_faces(recorder, setup);
  constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
  gpu::Image& stored = recorder.image({"surfaces", kWords, setup.width, setup.height, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, false});
  gpu::Image& count = map_image(recorder, setup, "surfaces");
  gpu::Image& dropped = map_image(recorder, setup, "dropped");
  setup.outputs.maps.emplace_back("surfaces", &count);
  setup.outputs.maps.emplace_back("dropped", &dropped);
  gpu::RasterPass analyse = lighting_pass(setup, "analyse", "techniques/sbaa/analyse.frag");
  analyse.pipeline.constants.emplace_back(SBAA_CONSTANT_SURFACES, kept);
  analyse.pipeline.constants.emplace_back(SBAA_CONSTANT_MERGE, merges(setup) ? 1 : 0);
  analyse.pipeline.targets.clear = true;
  analyse.colours = {{stored}, {count}, {dropped}};
  analyse.clear_colours = {{}, {}, {}};
  analyse.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  analyse.push = gpu::PushConstants(gpu_types::SbaaAnalysePush{
      .faces = analyse.reads(faces), .cosine = static_cast<float>(std::cos(setup.parameters.normal_angle))});
  recorder.raster(analyse);

  gpu::Image& gbuffer = stored_samples(recorder, setup, "G-buffer", kept);
  ListedPass pass;
  pass.name = "surfaces";
  pass.shader = std::string("techniques/sbaa/surfaces.comp") + stored_sample_variant(setup);
  pass.constants = common_constants(setup);
  pass.constants.emplace_back(SBAA_CONSTANT_SURFACES, kept);
  pass.bindings = {gpu::samples(SBAA_SLOT_SURFACES, stored), gpu::image_writes(SBAA_SLOT_STORED, gbuffer)};
  record_listed_fragments(recorder, setup, visible.lists, pass);

  gpu::Image& sum = sum_image(recorder, setup);
  gpu::RasterPass shade = lighting_pass(setup, "shade", "techniques/sbaa/shade.frag");
  shade.pipeline.constants.emplace_back(SBAA_CONSTANT_SURFACES, kept);
  shade.pipeline.targets.clear = true;
  shade.colours = {{sum}};
  shade.clear_colours = {{}};
  shade.bindings.insert(shade.bindings.end(),
                        {gpu::samples(FRAME_SLOT_VISIBILITY, visibility), gpu::samples(SBAA_SLOT_SURFACES, stored),
                         gpu::samples(SBAA_SLOT_GBUFFER, gbuffer), gpu::samples(SBAA_SLOT_DROPPED, dropped)});
  if (setup.story != nullptr) record_story(recorder, setup, analyse, shade);
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
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
