// The value of one sample of a G-buffer of full samples, lit or sky.
// Reads: visibility, G-buffer (one layer for each sample it holds), shadow map. Needs lights.glsl's frame.
#ifndef SUBPIXEL_FULL_SAMPLE_GLSL
#define SUBPIXEL_FULL_SAMPLE_GLSL

#include "deferred/stored_sample.glsl"
#include "include/lights.glsl"
#include "include/visibility.glsl"
#include "include/resolve.glsl"
#include "frontend/sample_patterns.h"
#include "shade/shade_interface.h"
#include "story/lighting.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = SAMPLED(SHADE_SLOT_GBUFFER)) uniform usampler2DArray gbuffer;

// rgb the resolvable value, a the lighting executions, 1 or 0; `layer` of the G-buffer holds sample s.
vec4 full_sample_value(ivec2 pixel, uint s, uint layer) {
  uint depth, triangle;
  if (SAMPLES == 1u) {
    uvec2 one = visible_sample(pixel);
    depth = one.x;
    triangle = one.y;
  } else {
    depth = visible_depths(pixel, SAMPLES, s / 4u)[s & 3u];
    triangle = visible_triangles(pixel, SAMPLES, s / 4u)[s & 3u];
  }
  // A loop, so that groups of pixels that show the sky alone skip the lighting.
  vec4 value = vec4(resolvable(frame.sky.rgb), 0.0);
  for (bool covered = triangle != SUBPIXEL_NO_TRIANGLE; covered; covered = false) {
    vec2 position = vec2(frame_pixel(pixel)) + 0.5 + vec2(sample_offset(SAMPLES, s)) * (1.0 / 128.0);
    Surface surface = surface_of_stored(texelFetch(gbuffer, ivec3(pixel, layer), 0));
    surface.position = world_position(position, uintBitsToFloat(depth));
    value = vec4(resolvable(shade(surface, normalize(frame.eye.xyz - surface.position))), 1.0);
    TELL_EXECUTION(pixel, s, 1u, s < 32u ? uvec2(1u << s, 0u) : uvec2(0u, 1u << (s & 31u)), surface.position,
                   value.rgb);
  }
  return value;
}

#endif
