// Deferred shading of one sample, then a filter over the finished image that smooths steps along edges of luminance.
// The idea is that of Lottes 2009, "FXAA" (and Reshetov 2009, "Morphological antialiasing"); the filter is our own. It
// needs no geometry memory and can't show what one sample a pixel missed.
#include "replay/frontend/visibility.hpp"
#include "replay/techniques/deferred.hpp"
#include "shaders/techniques/fxaa/fxaa_interface.h"

namespace subpixel::replay {
namespace {

MemoryLayout layout(const FrameSetup& setup) {
  const double n = setup.samples;
  MemoryLayout memory;
  memory.paper = {{"depth", 32 * n}, {"G-buffer samples", 128 * n}};
  memory.fitted = {{"depth", 32 * n}, {"G-buffer samples", fitted_surface_bits(setup.scene.features()) * n}};
  return memory;
}

void record_filter(gpu::PassRecorder& recorder, const FrameSetup& setup, gpu::Image& values) {
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
  pass.push =
      gpu::PushConstants(gpu_types::FxaaPush{.relative_threshold = static_cast<float>(setup.number("edge_threshold")),
                                             .least_contrast = static_cast<float>(setup.number("least_contrast")),
                                             .blur = static_cast<float>(setup.number("blur")),
                                             .steps = setup.parameters.at("search_steps").get<std::uint32_t>()});
  recorder.raster(std::move(pass));
}

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, setup);
  gpu::Image& gbuffer = gbuffer_image(recorder, setup);
  gpu::Image& sum = sum_image(recorder, setup);
  record_gbuffer(recorder, setup, visibility, gbuffer, 0);
  record_sample_shading(recorder, setup, visibility, gbuffer, sum, 0);
  record_resolve(recorder, setup, sum);
  record_filter(recorder, setup, sum);
}

Parameters parameters() {
  Parameter edge_threshold;
  edge_threshold.name = "edge_threshold";
  edge_threshold.kind = ParameterKind::number;
  edge_threshold.doc = "least contrast of an edge as a fraction of the brightest neighbour's luminance";
  edge_threshold.minimum = 0;
  edge_threshold.maximum = 1;
  edge_threshold.default_value = 0.125;
  Parameter least_contrast = edge_threshold;
  least_contrast.name = "least_contrast";
  least_contrast.doc = "least contrast of an edge in display values, which keeps dark noise as it is";
  least_contrast.default_value = 0.03;
  Parameter blur = edge_threshold;
  blur.name = "blur";
  blur.doc = "strength of the low-pass on dots and lines thinner than a pixel";
  blur.default_value = 0.75;
  Parameter search_steps;
  search_steps.name = "search_steps";
  search_steps.kind = ParameterKind::integer;
  search_steps.doc = "how far an edge is followed in each direction: quality against time";
  search_steps.unit = "pixels";
  search_steps.minimum = 0;
  search_steps.maximum = 64;
  search_steps.default_value = 16;
  return {samples_parameter({1}, 1), edge_threshold,      least_contrast,     blur, search_steps,
          alpha_parameter(),         resolve_parameter(), shading_parameter()};
}

}  // namespace

extern const Technique kFxaa;

const Technique kFxaa{"fxaa",
                      "No anti-aliasing, edges of luminance filtered",
                      "Lottes: FXAA. NVIDIA 2009 (the idea; the filter is our own)",
                      parameters(),
                      {{"changed", "Pixels the filter changed", "", 1}},
                      layout,
                      record};

}  // namespace subpixel::replay
