#version 460
#extension GL_GOOGLE_include_directive : require
// Shades every covered sample of a G-buffer of full samples and adds up the pixel; the sky shows in the others.
// Reads: visibility (slot 0), G-buffer (slot 1, one layer for each of GROUP_SAMPLES samples), shadow map. Writes (additively):
// rgb the sum of the samples' resolvable values, a the lighting executions.
#include "include/lights.glsl"
#include "include/packing.glsl"
#include "include/visibility.glsl"
#include "include/resolve.glsl"
#include "frontend/sample_patterns.h"

layout(constant_id = 0) const uint SAMPLES = 8u;
layout(constant_id = 4) const uint SAMPLE_GROUP = 0u;
layout(constant_id = 6) const uint GROUP_SAMPLES = 8u;
layout(set = 0, binding = 13) uniform usampler2DArray gbuffer;

layout(location = 0) out vec4 out_sum;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 sky = resolvable(frame.sky.rgb);
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < GROUP_SAMPLES; ++i) {
    uint s = SAMPLE_GROUP * GROUP_SAMPLES + i;
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
    vec4 value = vec4(sky, 0.0);
    for (bool covered = triangle != SUBPIXEL_NO_TRIANGLE; covered; covered = false) {
      vec2 position = gl_FragCoord.xy + vec2(sample_offset(SAMPLES, s)) * (1.0 / 128.0);
      Surface surface = unpack_surface(texelFetch(gbuffer, ivec3(pixel, i), 0));
      surface.position = world_position(position, uintBitsToFloat(depth));
      value = vec4(resolvable(shade(surface, normalize(frame.eye.xyz - surface.position))), 1.0);
    }
    sum += value;
  }
  out_sum = sum;
}
