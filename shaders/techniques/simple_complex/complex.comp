#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Shades all samples of the pixels in a list; one invocation for each pixel.
// Reads: the list, visibility, G-buffer of full samples, shadow map.
// Writes: rgb the sum of the samples' resolvable values, a the lighting executions.
layout(local_size_x = 64) in;
#include "shade/full_sample.glsl"
#include "techniques/simple_complex/simple_complex_interface.h"
#include "deferred/pixel_list.glsl"

layout(set = 0, binding = STORAGE(DEFERRED_SLOT_PIXEL_LIST), scalar) readonly buffer List {
  uint listed;
  uint list[];
};
layout(set = 0, binding = STORAGE_IMAGE(SIMPLE_COMPLEX_SLOT_SUM), rgba32f) writeonly uniform image2D out_sum;

void main() {
  uint place = pixel_list_place(gl_WorkGroupID, gl_LocalInvocationID.x);
  if (place >= listed) return;
  ivec2 pixel = ivec2(list[place] & 0xffffu, list[place] >> 16);
  vec4 sum = vec4(0.0);
  for (uint s = 0u; s < SAMPLES; ++s) sum += full_sample_value(pixel, s, s);
  imageStore(out_sum, pixel, sum);
}
