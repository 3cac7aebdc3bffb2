#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Adds up the lit fragments of each pixel, each weighted by the samples that show it; one invocation for each pixel.
// Reads: listed values. Writes: the numbers, sorted; rgb the sum over the pixel's samples, a the lighting executions.
layout(local_size_x = 64) in;
#include "frontend/fragment_lists.glsl"
#include "include/resolve.glsl"
#include "shade/shade_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = STORAGE_IMAGE(SHADE_SLOT_SUM_IMAGE), rgba32f) writeonly uniform image2D sum_image;
layout(push_constant, scalar) uniform Push { VisibleFragmentsPush push; };

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uvec2 range = list_range(push.lists, uint(pixel.y) * push.width + uint(pixel.x));
  sort_list(push.lists.numbers, range.x, range.y);
  uint covered = 0u;
  for (uint i = range.x; i < range.y; ++i) covered += push.lists.fragments.fragment[push.lists.numbers.number[i]].w;
  // Products and sums are rounded, never fused, as blending one fragment after the other rounds them.
  precise vec3 sum = resolvable(frame.sky.rgb) * float(SAMPLES - covered);
  for (uint i = range.x; i < range.y; ++i) {
    uvec4 fragment = push.lists.fragments.fragment[push.lists.numbers.number[i]];
    precise vec3 part = uintBitsToFloat(fragment.xyz) * float(fragment.w);
    sum += part;
  }
  imageStore(sum_image, pixel, vec4(sum, float(range.y - range.x)));
}
