// The samples a fragment covers: its triangle's, less what the material's alpha takes.
// Reads: what fragment.glsl reads; with WITH_UV the material's textures.
#ifndef SUBPIXEL_DCAA_FRAGMENT_MASK_GLSL
#define SUBPIXEL_DCAA_FRAGMENT_MASK_GLSL

#include "frontend/fragment.glsl"
#include "techniques/dcaa/surface.glsl"
#include "techniques/dcaa/coverage.glsl"

// Where attributes are evaluated: the centre when the triangle covers it, else the centroid of its samples.
vec2 mask_shading_offset(PixelEdges edges, uvec2 geometry) {
  vec2 offset = vec2(0.0);
  for (bool go = !covers(edges, ivec2(0)); go; go = false) offset = mask_centroid(geometry);
  return offset;
}

#ifdef WITH_UV
uvec2 alpha_coverage(uvec2 geometry, ivec2 pixel, vec2 offset) {
  return uvec2(alpha_mask(geometry.x, 0u, min(SAMPLES, 32u), pixel, offset),
               SAMPLES > 32u ? alpha_mask(geometry.y, 32u, 32u, pixel, offset) : 0u);
}
#endif

#endif
