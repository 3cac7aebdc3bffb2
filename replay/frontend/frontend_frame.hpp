// A frame as the passes of the front-end see it.
#pragma once

#include <cstdint>

#include "replay/frontend/frontend.hpp"

namespace subpixel::replay {

// How alpha-tested materials decide; values of the specialization constant.
enum class AlphaDecision : std::uint32_t { to_coverage = 0, test = 1, per_sample = 2 };

// How triangles of a few pixels are rasterised: as hulls like all others, or found in lists by block of pixels. Both
// leave the same bits.
enum class SmallTriangles { as_hulls, in_lists };

// `frontend` is prepared for the scene's current frame, which has that size in pixels.
struct FrontendFrame {
  Frontend& frontend;
  std::uint32_t width = 0, height = 0;
  AlphaDecision alpha = AlphaDecision::to_coverage;
  SmallTriangles small = SmallTriangles::as_hulls;
};

}  // namespace subpixel::replay
