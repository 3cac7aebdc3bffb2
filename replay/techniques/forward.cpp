// Forward shading with multi-sampled visibility: what the papers call their visual reference. Akeley 1993,
// "RealityEngine graphics": a fragment is shaded once and its colour goes to all samples it covers. The visibility
// buffer comes first, so only fragments that some sample shows are lit, as after a depth pre-pass; their colours are
// added up with the number of those samples as weight, which leaves the same pixel as n stored colours would.
#include "replay/frontend/visibility.hpp"
#include "replay/techniques/deferred.hpp"

namespace subpixel::replay {
namespace {

MemoryLayout layout(const FrameSetup& setup) {
  const double n = setup.samples;
  // A multi-sampled colour buffer of 4 bytes, as the streaming paper counts its lighting buffer, and depth.
  return {{"depth", 32 * n}, {"colour samples", 32 * n}};
}

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  setup.frontend.record_setup(recorder);
  gpu::Image& visibility = record_visibility(recorder, setup);
  gpu::Image& sum = sum_image(recorder, setup);

  gpu::RasterPass background = lighting_pass(setup, "background", "techniques/forward/background.frag");
  background.pipeline.targets.clear = true;
  background.colours = {{sum}};
  background.clear_colours = {{}};
  background.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  recorder.raster(std::move(background));

  Frontend::GeometryPass geometry;
  geometry.by_material = true;
  geometry.fragment_opaque = "techniques/forward/forward.frag";
  gpu::RasterPass& pass = geometry.pass;
  pass.name = "forward";
  pass.pipeline.constants = common_constants(setup);
  pass.pipeline.additive = true;
  pass.colours = {{sum}};
  pass.bindings = light_bindings(setup);
  pass.bindings.push_back(gpu::samples(FRAME_SLOT_VISIBILITY, visibility));
  setup.frontend.record_geometry(recorder, std::move(geometry));
  record_resolve(recorder, setup, sum);
}

}  // namespace

extern const Technique kForward;

const Technique kForward = TechniqueOf<CommonParameters>{
    .name = "forward",
    .title = "Forward MSAA, one shading per visible fragment",
    .paper = "Akeley: RealityEngine graphics. SIGGRAPH 1993",
    .fields = {field::samples({4, 8, 16, 32, 64}), field::alpha(), field::resolve(), field::shading()},
    .maps = {},
    .layout = layout,
    .record = record,
};

}  // namespace subpixel::replay
