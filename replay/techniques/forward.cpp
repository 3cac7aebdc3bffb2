// Forward shading with multi-sampled visibility: what the papers call their visual reference. Akeley 1993,
// "RealityEngine graphics": a fragment is shaded once and its colour goes to all samples it covers. The visibility
// buffer comes first, so only fragments that some sample shows are lit, as after a depth pre-pass; their colours are
// added up with the number of those samples as weight, which leaves the same pixel as n stored colours would. They are
// lit from lists of what shows, as `visibility` does.
#include "replay/techniques/visible_shading.hpp"

namespace subpixel::replay {
namespace {

MemoryLayout layout(const FrameSetup& setup) {
  const double n = setup.samples;
  // A multi-sampled colour buffer of 4 bytes, as the streaming paper counts its lighting buffer, and depth.
  return {{"depth", 32 * n}, {"colour samples", 32 * n}};
}

void record(gpu::PassRecorder& recorder, const FrameSetup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  record_listed_fragments(recorder, setup, visible.lists,
                          visible_shading(setup, ShadingPoint::covered, "techniques/visibility/shade.comp"));
  record_visible_resolve(recorder, setup, visible.lists);
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
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
