// The visibility buffer: n samples of a triangle number and a depth are all that geometry leaves. Shading fetches the
// triangle's vertices by its number, interpolates them and lights it, once for each triangle that a pixel shows.
// Burns and Hunt 2013, "The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading", JCGT 2 (2).
// Shading goes through the visible fragments material by material, so that each invocation has its textures bound; the
// publication's own shading pass goes through pixels.
#include "replay/techniques/visible_shading.hpp"

namespace subpixel::replay {
namespace {

struct VisibilityParameters : CommonParameters {
  ShadingPoint point = ShadingPoint::covered;
};

using Setup = SetupFor<VisibilityParameters>;

MemoryLayout layout(const Setup& setup) {
  const double n = setup.samples;
  // Triangle and instance in four bytes, and depth: nothing else is stored, since pixels are written as they are lit.
  return {{"depth", 32 * n}, {"triangle numbers", 32 * n}};
}

void record(gpu::PassRecorder& recorder, const Setup& setup) {
  const VisibleFragments visible = record_visible(recorder, setup);
  record_listed_fragments(recorder, setup, visible.lists,
                          visible_shading(setup, setup.parameters.point, "techniques/visibility/shade.comp"));
  record_visible_resolve(recorder, setup, visible.lists);
}

}  // namespace

extern const Technique kVisibility;

const Technique kVisibility = TechniqueOf<VisibilityParameters>{
    .name = "visibility",
    .title = "Visibility buffer, attributes from the vertices",
    .paper = "Burns, Hunt: The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading. JCGT 2 (2), 2013",
    .fields = {field::samples({1, 2, 4, 8, 16, 32, 64}), field::shading_point(&VisibilityParameters::point),
               field::alpha(), field::resolve(), field::shading()},
    .maps = {},
    .layout = layout,
    .record = record,
    .lists = ListedMasks::visible,
};

}  // namespace subpixel::replay
