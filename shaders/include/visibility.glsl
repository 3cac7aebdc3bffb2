// Reads the visibility image: depth bits and triangle of each sample of a pixel.
// Reads: visibility. Layers as visibility.frag writes them: groups of up to 16 samples, each group its depths, then its
// triangles, four samples in a texel. Two samples share one texel, both depths and both triangles.
#ifndef SUBPIXEL_VISIBILITY_GLSL
#define SUBPIXEL_VISIBILITY_GLSL

#include "frontend/frontend_types.h"
#include "include/interface.h"

layout(set = 0, binding = SAMPLED(FRAME_SLOT_VISIBILITY)) uniform usampler2DArray visibility;

// Samples 4 quad .. 4 quad + 3 of n >= 2; of those beyond n, depth 0 and no triangle.
uvec4 visible_depths(ivec2 pixel, uint n, uint quad) {
  if (n == 2u) return uvec4(texelFetch(visibility, ivec3(pixel, 0), 0).xy, 0u, 0u);
  uint per_group = min(n, 16u) / 4u;
  uint layer = quad / per_group * 2u * per_group + quad % per_group;
  return texelFetch(visibility, ivec3(pixel, layer), 0);
}

uvec4 visible_triangles(ivec2 pixel, uint n, uint quad) {
  if (n == 2u) return uvec4(texelFetch(visibility, ivec3(pixel, 0), 0).zw, uvec2(SUBPIXEL_NO_TRIANGLE));
  uint per_group = min(n, 16u) / 4u;
  uint layer = quad / per_group * 2u * per_group + per_group + quad % per_group;
  return texelFetch(visibility, ivec3(pixel, layer), 0);
}

// n == 1: depth bits and triangle.
uvec2 visible_sample(ivec2 pixel) { return texelFetch(visibility, ivec3(pixel, 0), 0).xy; }

#endif
