// How shaded samples add up to a pixel: linear radiance, or values already tone-mapped (RESOLVE_TONE_MAPPED).
// Reads: frame constants.
#ifndef SUBPIXEL_RESOLVE_GLSL
#define SUBPIXEL_RESOLVE_GLSL

#include "include/tone.glsl"

layout(constant_id = CONSTANT_RESOLVE) const uint RESOLVE_TONE_MAPPED = 0u;

// What one sample of radiance contributes to the pixel's sum.
vec3 resolvable(vec3 radiance) {
  return RESOLVE_TONE_MAPPED != 0u ? tone_curve(radiance * frame.tone.x) : radiance;
}

// Linear radiance that displays as the mean tone-mapped value `y` in [0, 1).
vec3 radiance_of_tone(vec3 y) {
  y = clamp(y, 0.0, 0.99999);
  vec3 a = 2.43 * (1.0 - y), b = 0.03 - 0.59 * y, c = -0.14 * y;
  return (-b + sqrt(max(b * b - 4.0 * a * c, 0.0))) / (2.0 * a) / max(frame.tone.x, 1e-20);
}

// The pixel's linear radiance, of the mean of resolvable() over its samples.
vec3 resolved_radiance(vec3 mean) { return RESOLVE_TONE_MAPPED != 0u ? radiance_of_tone(mean) : mean; }

#endif
