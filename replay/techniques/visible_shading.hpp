// Shading after a visibility buffer: each triangle that a pixel shows is lit once, and what that gives is weighted by
// the samples that show it. Shared by the techniques that differ in where attributes come from.
#pragma once

#include "replay/frame/technique.hpp"
#include "shaders/shade/shade_interface.h"

namespace subpixel::replay {

enum class ShadingPoint : std::uint32_t { covered = SHADE_POINT_COVERED, visible = SHADE_POINT_VISIBLE };

namespace field {
template <typename P>
Field<P> shading_point(ShadingPoint P::*member) {
  return choice("point", member,
                "a triangle is lit at the pixel's centre where it covers that, or where all samples show it; else at "
                "the centroid of the samples that it covers, or of those that show it",
                {{"covered", ShadingPoint::covered}, {"visible", ShadingPoint::visible}});
}
}  // namespace field

// A pass "shade" over the fragments, material by material, which reads the lights; `shader` leaves each one's value as
// shade/listed_values.glsl stores it.
ListedPass visible_shading(const FrameSetup& setup, ShadingPoint point, std::string shader);

// The outputs from the values, passes "sum" and "resolve".
void record_visible_resolve(gpu::PassRecorder& recorder, const FrameSetup& setup, const FragmentLists& lists);

}  // namespace subpixel::replay
