#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Shades the kept surfaces of a pixel; the samples of those that were not kept are left out of the mean.
// Reads: visibility, surfaces, their G-buffer, samples not kept, shadow map.
// Writes: rgb the sum of the samples' resolvable values, a the lighting executions.
#include "deferred/stored_sample.glsl"
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "include/visibility.glsl"
#include "frontend/sample_patterns.h"
#include "techniques/sbaa/sbaa_interface.h"
#include "techniques/sbaa/surface_words.glsl"
#include "story/lighting.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = SBAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
layout(set = 0, binding = SAMPLED(SBAA_SLOT_SURFACES)) uniform usampler2D surfaces;
layout(set = 0, binding = SAMPLED(SBAA_SLOT_GBUFFER)) uniform usampler2DArray gbuffer;
layout(set = 0, binding = SAMPLED(SBAA_SLOT_DROPPED)) uniform usampler2D dropped;
layout(location = 0) out vec4 out_sum;

#ifdef STORY
#include "techniques/sbaa/story_interface.h"
layout(set = 0, binding = STORAGE(SBAA_SLOT_STORY), scalar) buffer Story {
  uvec4 kept_told;  // pixel, surfaces
  SbaaKept kept_at[];
};
void tell_kept(ivec2 pixel, uint slot, uint word, uvec4 packed) {
  for (bool tell = pixel == ivec2(kept_told.xy); tell; tell = false) {
    kept_at[kept_told.z].head = uvec4(slot, surface_first(word), surface_samples(word), 0u);
    kept_at[kept_told.z].surface = packed;
    kept_told.z = kept_told.z + 1u;
  }
}
#define TELL_KEPT(pixel, slot, word, packed) tell_kept(pixel, slot, word, packed)
#else
#define TELL_KEPT(pixel, slot, word, packed)
#endif

// Where the attributes of a surface were taken, as near as depth and description tell: the pixel's centre when it has all
// samples, else its first sample.
vec3 surface_position(ivec2 pixel, uint word) {
  uint s = surface_first(word);
  vec2 offset = vec2(sample_offset(SAMPLES, s)) * (1.0 / 128.0);
  float depth = uintBitsToFloat(visible_depths(pixel, SAMPLES, s / 4u)[s & 3u]);
  for (bool all_samples = surface_samples(word) == SAMPLES; all_samples; all_samples = false) {
    vec4 sum = vec4(0.0);
    for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) sum += uintBitsToFloat(visible_depths(pixel, SAMPLES, quad));
    offset = vec2(0.0);
    depth = (sum.x + sum.y + sum.z + sum.w) / float(SAMPLES);
  }
  return world_position(vec2(frame_pixel(pixel)) + 0.5 + offset, depth);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  uint uncovered = SAMPLES - texelFetch(dropped, pixel, 0).x;
  vec3 sum = vec3(0.0);
  float executions = 0.0;
  uint weight = 0u;
  for (uint k = 0u; k < SURFACES; ++k) {
    uint word = stored_surface(texel, k);
    // A loop, so that groups of pixels that have no such surface skip the lighting.
    for (bool stored = word != 0u; stored; stored = false) {
      uvec4 stored_words = texelFetch(gbuffer, ivec3(pixel, k), 0);
      Surface surface = surface_of_stored(stored_words);
      TELL_KEPT(pixel, k, word, packed_of_stored(stored_words));
      surface.position = surface_position(pixel, word);
      vec3 value = resolvable(shade(surface, normalize(frame.eye.xyz - surface.position)));
      TELL_EXECUTION(pixel, k, surface_samples(word), uvec2(1u << surface_first(word), 0u), surface.position, value);
      sum += value * float(surface_samples(word));
      weight += surface_samples(word);
      executions += 1.0;
    }
  }
  uncovered -= weight;
  weight += uncovered;
  sum += resolvable(frame.sky.rgb) * float(uncovered);
  out_sum = vec4(sum * (float(SAMPLES) / float(weight)), executions);
}
