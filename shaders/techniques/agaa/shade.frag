#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Aggregate deferred shading (AGAA paper, section 3.5): one lighting execution for each aggregate of a pixel, composited by
// samples over the sky.
// Reads: visibility (slot 0), the pixel's aggregates, shadow map.
// Writes: linear radiance with the lighting executions in a; display values.
#include "techniques/agaa/agaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
#include "include/resolve.glsl"
#include "include/visibility.glsl"
#include "techniques/agaa/shading.glsl"
#include "techniques/agaa/footprint.glsl"
#include "techniques/agaa/sums_access.glsl"
#include "story/lighting.glsl"

layout(push_constant, scalar) uniform Push { AgaaShadePush push; };
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  uint shaded = 0u, executions = 0u;
  for (uint k = 0u; k < AGGREGATES; ++k) {
    uint mask = aggregate_mask(state.sums.words[first_word(pixel, k) + kMaskWord]);
    // A loop, so that groups of pixels without such an aggregate skip the lighting.
    for (bool stored = mask != 0u; stored; stored = false) {
      Aggregate a = aggregate_of_words(stored_words(pixel, k), frame.tone.y, state.largest_emission);
      vec3 view;
      Footprint footprint = aggregate_footprint(push.view_from_clip, pixel, mask, view);
      vec3 value = resolvable(shade_aggregate(a, footprint, view));
      TELL_EXECUTION(pixel, k, uint(bitCount(mask)), uvec2(mask, 0u), footprint.mean, value);
      sum += float(int(bitCount(mask))) * value;
      shaded += bitCount(mask);
      ++executions;
    }
  }
  vec3 mean = (sum + resolvable(frame.sky.rgb) * float(int(SAMPLES - shaded))) / float(SAMPLES);
  vec3 radiance = resolved_radiance(mean);
  out_radiance = vec4(radiance, float(int(executions)));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
