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

// `frontend` is prepared for the scene's current frame, which has that size in pixels. Where the scene's band is not
// all of it, `height` is the band's.
struct FrontendFrame {
  Frontend& frontend;
  std::uint32_t width = 0, height = 0;
  AlphaDecision alpha = AlphaDecision::to_coverage;
  SmallTriangles small = SmallTriangles::as_hulls;
  // Of these rows, those that count; the others are there for what looks at neighbours. `kept_rows` 0: all count.
  std::uint32_t kept_first = 0, kept_rows = 0;
};

}  // namespace subpixel::replay
