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

// The triangle that sample s of n >= 1 shows.
uint visible_triangle(ivec2 pixel, uint n, uint s) {
  if (n == 1u) return visible_sample(pixel).y;
  return visible_triangles(pixel, n, s / 4u)[s & 3u];
}

// The samples of n >= 1, sample s in bit s, that show `triangle`.
uvec2 samples_showing(ivec2 pixel, uint n, uint triangle) {
  if (n == 1u) return uvec2(visible_sample(pixel).y == triangle ? 1u : 0u, 0u);
  uvec2 mask = uvec2(0u);
  for (uint quad = 0u; quad < (n + 3u) / 4u; ++quad) {
    uvec4 same = uvec4(equal(visible_triangles(pixel, n, quad), uvec4(triangle)));
    mask[quad / 8u] |= (same.x | same.y << 1 | same.z << 2 | same.w << 3) << (4u * (quad & 7u));
  }
  return n == 2u ? mask & 3u : mask;
}

#endif
