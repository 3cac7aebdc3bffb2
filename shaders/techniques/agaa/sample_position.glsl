// View-space positions of a pixel's samples, from their depths.
// Reads: nothing but its arguments. View space, since it has no large offsets to lose digits to.
#ifndef SUBPIXEL_AGAA_SAMPLE_POSITION_GLSL
#define SUBPIXEL_AGAA_SAMPLE_POSITION_GLSL

#include "frontend/sample_patterns.h"

// `pixel`: of the frame; `offset` from the pixel's centre in pixels, `depth` reversed, `viewport` as in the frame constants.
vec3 view_position(mat4 view_from_clip, vec4 viewport, ivec2 pixel, vec2 offset, float depth) {
  vec2 ndc = (vec2(pixel) + 0.5 + offset) * viewport.zw * 2.0 - 1.0;
  vec4 p = view_from_clip * vec4(ndc, depth, 1.0);
  return p.xyz / (abs(p.w) < 1e-12 ? 1e-12 : p.w);
}

#endif
