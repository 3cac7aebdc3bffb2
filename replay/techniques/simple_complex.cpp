// Deferred MSAA that shades pixels whose samples agree once and the others per sample. Lauritzen 2010, "Deferred
// rendering for current and future rendering pipelines", the baseline of the streaming and the aggregate papers. All n
// samples of the G-buffer are kept, since pixels are classified before any is shaded. Complex pixels are gathered in a
// list, so that the lanes of a group all have n samples to shade.
#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/simple_complex/simple_complex_interface.h"

namespace subpixel::replay {
namespace {

struct SimpleComplexParameters : PrepassParameters {
  double depth_threshold = 1, normal_threshold = 0.99;
  bool compact = true;
};
using Setup = SetupFor<SimpleComplexParameters>;

MemoryLayout layout(const Setup& setup) {
  const double n = setup.samples;
  // Streaming paper, table 1: 20-byte samples and a multi-sampled lighting buffer: 192 bytes a pixel at 8x, 96 at 4x.
  return {{"depth", 32 * n}, {"G-buffer samples", 128 * n}, {"lighting buffer", 32 * n}};
}

gpu::Image& record_classification(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& visibility,
                                  gpu::Image& gbuffer) {
  gpu::Image& flags = map_image(recorder, setup, "complex");
  setup.outputs.maps.emplace_back("complex", &flags);
  gpu::RasterPass pass = lighting_pass(setup, "classify", "techniques/simple_complex/classify.frag");
  pass.pipeline.targets.clear = true;
  pass.colours = {{flags}};
  pass.clear_colours = {{}};
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  pass.bindings.push_back(gpu::samples(SHADE_SLOT_GBUFFER, gbuffer));
  pass.push = gpu::PushConstants(
      gpu_types::SimpleComplexClassifyPush{.records = pass.reads(setup.frontend.records()),
                                           .depth_scale = static_cast<float>(setup.parameters.depth_threshold),
                                           .least_cosine = static_cast<float>(setup.parameters.normal_threshold)});
  recorder.raster(std::move(pass));
  return flags;
}

SampleImages record_samples(gpu::PassRecorder& recorder, const Setup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  gpu::Image& gbuffer = gbuffer_image(recorder, setup, true);
  for (std::uint32_t group = 0; group < setup.samples / gbuffer_group(setup.samples); ++group)
    record_gbuffer(recorder, setup, visible, gbuffer, group);
  return {*visible.visibility, gbuffer};
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const auto [visibility, gbuffer] =
      setup.parameters.prepass ? record_samples(recorder, setup) : record_gbuffer_in_order(recorder, setup);
  gpu::Image& flags = record_classification(recorder, setup, visibility, gbuffer);
  gpu::Image& sum = sum_image(recorder, setup);
  const bool compact = setup.parameters.compact;

  gpu::RasterPass simple = lighting_pass(
      setup, "shade simple",
      compact ? "techniques/simple_complex/simple.frag:SIMPLE" : "techniques/simple_complex/simple.frag:BOTH");
  simple.pipeline.targets.clear = true;
  simple.colours = {{sum}};
  simple.clear_colours = {{}};
  simple.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  simple.bindings.push_back(gpu::samples(SHADE_SLOT_GBUFFER, gbuffer));
  simple.bindings.push_back(gpu::samples(SIMPLE_COMPLEX_SLOT_FLAGS, flags));
  const std::vector<gpu::Binding> lights = lighting_pass(setup, "", "").bindings;
  const gpu::Constants constants = simple.pipeline.constants;
  if (setup.story != nullptr) {
    setup.story->record_lighting(recorder, simple, "techniques/simple_complex/simple.frag:STORY");
    // One sample stands for all.
    setup.story->amend([](nlohmann::json& told) {
      const auto samples = told["samples"].get<std::uint32_t>();
      if (told["maps"]["complex"] != 0) return;
      for (nlohmann::json& execution : told["executions"]) {
        execution["weight"] = samples;
        execution["samples"] = mask_text(~std::uint64_t{0} >> (64 - samples));
      }
    });
  }
  recorder.raster(std::move(simple));

  if (compact) {
    const PixelList list = record_pixel_list(recorder, setup, flags);
    gpu::ComputePass complex;
    complex.name = "shade complex";
    complex.shader = "techniques/simple_complex/complex.comp";
    complex.constants = constants;
    complex.bindings = lights;
    complex.bindings.insert(
        complex.bindings.end(),
        {gpu::samples(FRAME_SLOT_VISIBILITY, visibility), gpu::samples(SHADE_SLOT_GBUFFER, gbuffer),
         gpu::reads(DEFERRED_SLOT_PIXEL_LIST, *list.pixels), gpu::image_writes(SIMPLE_COMPLEX_SLOT_SUM, sum)});
    complex.indirect = list.groups;
    recorder.compute(std::move(complex));
  }
  record_resolve(recorder, setup, sum);
}

}  // namespace

extern const Technique kSimpleComplex;

const Technique kSimpleComplex = TechniqueOf<SimpleComplexParameters>{
    .name = "simple_complex",
    .title = "Deferred MSAA, pixels whose samples agree shaded once",
    .paper = "Lauritzen: Deferred rendering for current and future rendering pipelines. SIGGRAPH 2010 course",
    .fields = {field::samples({4, 8, 16, 32}),
               field::number("depth_threshold", &SimpleComplexParameters::depth_threshold, {0, 1000},
                             "depths agree within this many times |dz/dx| + |dz/dy| of sample 0"),
               field::number("normal_threshold", &SimpleComplexParameters::normal_threshold, {-1, 1},
                             "normals agree when the cosine between them is not below this"),
               field::condition("compact", &SimpleComplexParameters::compact,
                                "complex pixels are gathered in a list and shaded in a pass of their own; the image is "
                                "the same without"),
               field::prepass(), field::alpha(), field::resolve(), field::shading()},
    .maps = {{"complex", "Complex pixels", "shaded per sample", 1}, written_map()},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
