// Small triangles (COUNT_SMALL_ bits) outside of the rasteriser: the cells of the screen that one may touch.
#ifndef SUBPIXEL_SMALL_TRIANGLES_GLSL
#define SUBPIXEL_SMALL_TRIANGLES_GLSL

#include "frontend/frontend_types.h"

// Cells are pixels or, in lists by block, the 4x2 pixels that lavapipe shades as one vector; as shifts.
const ivec2 kPixelCell = ivec2(0), kBlockCell = ivec2(2, 1);

uint blocks_in_row(uint width) { return (width + 3u) >> 2; }

// Cells [first, last] whose pixels can hold a covered sample: one is less than half a pixel (and 1/128) from its pixel's centre.
// Vertices as in TriangleRecord; `size` of the viewport, pixels.
void cells_in_reach(ivec2 v0, ivec2 v1, ivec2 v2, ivec2 size, ivec2 cell, out ivec2 first, out ivec2 last) {
  ivec2 low = min(min(v0, v1), v2), high = max(max(v0, v1), v2);
  first = max((low - 1) >> 8, ivec2(0)) >> cell;
  last = min((high + 1) >> 8, size - 1) >> cell;
}

#endif
