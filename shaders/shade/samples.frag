#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Shades every covered sample of a G-buffer of full samples and adds up the pixel; the sky shows in the others.
// Reads: visibility, G-buffer (one layer for each of GROUP_SAMPLES samples, or of all), shadow map. Writes (additively):
// rgb the sum of the samples' resolvable values, a the lighting executions.
#include "shade/full_sample.glsl"

layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;
layout(constant_id = CONSTANT_GROUP_SAMPLES) const uint GROUP_SAMPLES = 8u;

layout(location = 0) out vec4 out_sum;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0.0);
  uint first = SAMPLE_GROUP * GROUP_SAMPLES, first_layer = uint(textureSize(gbuffer, 0).z) > GROUP_SAMPLES ? first : 0u;
  for (uint i = 0u; i < GROUP_SAMPLES; ++i) sum += full_sample_value(pixel, first + i, first_layer + i);
  out_sum = sum;
}
