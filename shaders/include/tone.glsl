// Linear radiance to display values.
// The curve is Narkowicz's rational fit of the ACES filmic curve (2016) with its numerator scaled so that it tends to
// 1 and needs no clamp: smooth and strictly rising from 0 to 1. It acts on each channel.
// Reads: frame.tone.x, the exposure.
#ifndef SUBPIXEL_TONE_GLSL
#define SUBPIXEL_TONE_GLSL

#include "include/frame.glsl"

vec3 tone_curve(vec3 x) {
  x = clamp(x, 0.0, 1e6);
  return (x * (2.43 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

// IEC 61966-2-1; `linear` in [0, 1].
vec3 srgb_encode(vec3 linear) {
  vec3 curved = 1.055 * pow(max(linear, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055;
  return mix(curved, linear * 12.92, lessThanEqual(linear, vec3(0.0031308)));
}

// Display values in [0, 1], sRGB-encoded, of linear radiance.
vec3 display_from_radiance(vec3 radiance) {
  return clamp(srgb_encode(tone_curve(radiance * frame.tone.x)), 0.0, 1.0);
}

#endif
