// Deferred shading of one sample, then a filter over the finished image that smooths steps along edges of luminance.
// The idea is that of Lottes 2009, "FXAA" (and Reshetov 2009, "Morphological antialiasing"); the filter is our own. It
// needs no geometry memory and can't show what one sample a pixel missed.
#include "replay/frame/pixel_story.hpp"
#include "replay/techniques/deferred.hpp"
#include "replay/techniques/fxaa_story.hpp"
#include "shaders/techniques/fxaa/fxaa_interface.h"

namespace subpixel::replay {
namespace {

struct FxaaParameters : CommonParameters {
  double edge_threshold = 0.125;
  double least_contrast = 0.03;
  double blur = 0.75;
  std::uint32_t search_steps = 16;

  FxaaParameters() { samples = 1; }
};
using Setup = SetupFor<FxaaParameters>;

void record_filter(gpu::PassRecorder& recorder, const Setup& setup, gpu::Image& values) {
  gpu::Image& unfiltered = *setup.outputs.display;
  gpu::ImageDescription output = unfiltered.description();
  setup.outputs.radiance = &recorder.image(output);
  setup.outputs.display = &recorder.image(output);
  output.name = "changed";
  output.format = VK_FORMAT_R32_UINT;
  gpu::Image& changed = recorder.image(output);
  setup.outputs.maps.emplace_back("changed", &changed);

  gpu::RasterPass pass = lighting_pass(setup, "filter", "techniques/fxaa/filter.frag");
  pass.pipeline.targets.clear = true;
  pass.colours = {{*setup.outputs.radiance}, {*setup.outputs.display}, {changed}};
  pass.clear_colours = {{}, {}, {}};
  pass.bindings.push_back(gpu::samples(FXAA_SLOT_DISPLAYED, unfiltered));
  pass.bindings.push_back(gpu::samples(FXAA_SLOT_VALUES, values));
  const gpu_types::FxaaPush push{.relative_threshold = static_cast<float>(setup.parameters.edge_threshold),
                                 .least_contrast = static_cast<float>(setup.parameters.least_contrast),
                                 .blur = static_cast<float>(setup.parameters.blur),
                                 .steps = setup.parameters.search_steps};
  pass.push = gpu::PushConstants(push);
  if (setup.story != nullptr) {
    gpu::Buffer& log = setup.story->record_log<gpu_types::FxaaStory>(recorder, "fxaa filter", 1);
    setup.story->record_again(recorder, pass, "techniques/fxaa/filter.frag:STORY", gpu::writes(FXAA_SLOT_STORY, log));
    setup.story->tell(
        "filter", [&log, push] { return fxaa_filter(PixelStory::log_of<gpu_types::FxaaStory>(log).front(), push); });
  }
  recorder.raster(std::move(pass));
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  gpu::Image& sum = record_shaded_samples(recorder, setup);
  record_resolve(recorder, setup, sum);
  record_filter(recorder, setup, sum);
}

}  // namespace

extern const Technique kFxaa;

const Technique kFxaa = TechniqueOf<FxaaParameters>{
    .name = "fxaa",
    .title = "No anti-aliasing, edges of luminance filtered",
    .paper = "Lottes: FXAA. NVIDIA 2009 (the idea; the filter is our own)",
    .fields = {field::samples({1}),
               field::number("edge_threshold", &FxaaParameters::edge_threshold, {0, 1},
                             "least contrast of an edge as a fraction of the brightest neighbour's luminance"),
               field::number("least_contrast", &FxaaParameters::least_contrast, {0, 1},
                             "least contrast of an edge in display values, which keeps dark noise as it is"),
               field::number("blur", &FxaaParameters::blur, {0, 1},
                             "strength of the low-pass on dots and lines thinner than a pixel"),
               field::integer("search_steps", &FxaaParameters::search_steps, {0, 64},
                              "how far an edge is followed in each direction: quality against time", "pixels"),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {{"changed", "Pixels the filter changed", "", 1}},
    .layout = full_sample_layout,
    .record = record,
    .lists = ListedMasks::visible,
    .neighbour_rows = [](const FxaaParameters& parameters) { return parameters.search_steps + 2; },
};

}  // namespace subpixel::replay
