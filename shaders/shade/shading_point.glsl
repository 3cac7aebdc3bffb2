// Where a visible fragment is lit: SHADE_POINT_.
// Reads: records. Needs fragment.glsl.
#ifndef SUBPIXEL_SHADING_POINT_GLSL
#define SUBPIXEL_SHADING_POINT_GLSL

#include "shade/shade_interface.h"

layout(constant_id = SHADE_CONSTANT_POINT) const uint POINT = SHADE_POINT_COVERED;

// Pixels from the pixel's centre; `shown`: the samples that show the fragment.
vec2 shading_point(ivec2 pixel, uvec2 shown) {
  if (POINT == SHADE_POINT_COVERED) return shading_offset(fragment_edges(pixel), SAMPLES);
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < SAMPLES; ++i) {
    bool shows = ((shown[i / 32u] >> (i & 31u)) & 1u) != 0u;
    sum += shows ? vec2(sample_offset(SAMPLES, i)) : vec2(0.0);
  }
  uint count = uint(bitCount(shown.x) + bitCount(shown.y));
  return count == SAMPLES ? vec2(0.0) : sum / (float(max(count, 1u)) * float(SUBPIXEL_SAMPLE_GRID));
}

#endif
