#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sorts one part of each list that has several; one invocation for each pixel.
// Reads: the pixels' ends. Reads and writes: the numbers.
layout(local_size_x = 64) in;
#include "frontend/fragment_lists.glsl"

layout(push_constant, scalar) uniform Push { ListPartPush push; };

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uvec2 range = list_range(push.lists, uint(pixel.y) * push.width + uint(pixel.x));
  uint begin = range.x + push.part * SUBPIXEL_LIST_PART;
  for (bool go = range.y - range.x > SUBPIXEL_LIST_PART && begin < range.y; go; go = false)
    sort_list(push.lists.numbers, begin, min(begin + SUBPIXEL_LIST_PART, range.y));
}
