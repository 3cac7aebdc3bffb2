#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Brings the sorted parts of each list that has several into one order; one invocation for each pixel.
// Reads: the pixels' ends. Reads and writes: the numbers; room for as many.
layout(local_size_x = 64) in;
#include "frontend/fragment_lists.glsl"

layout(push_constant, scalar) uniform Push { ListPartPush push; };

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uvec2 range = list_range(push.lists, uint(pixel.y) * push.width + uint(pixel.x));
  for (bool go = range.y - range.x > SUBPIXEL_LIST_PART; go; go = false) {
    // The next number of each part; above all numbers where the part is at its end.
    uint next[SUBPIXEL_LIST_PARTS], end[SUBPIXEL_LIST_PARTS], number[SUBPIXEL_LIST_PARTS];
    for (uint k = 0u; k < SUBPIXEL_LIST_PARTS; ++k) {
      next[k] = min(range.x + k * SUBPIXEL_LIST_PART, range.y);
      end[k] = min(next[k] + SUBPIXEL_LIST_PART, range.y);
      number[k] = next[k] < end[k] ? push.lists.numbers.number[next[k]] : 0xffffffffu;
    }
    for (uint i = range.x; i < range.y; ++i) {
      uint least = number[0];
      for (uint k = 1u; k < SUBPIXEL_LIST_PARTS; ++k) least = min(least, number[k]);
      push.merged.number[i] = least;
      for (uint k = 0u; k < SUBPIXEL_LIST_PARTS; ++k) {
        bool taken = number[k] == least;
        next[k] += taken ? 1u : 0u;
        uint ahead = push.lists.numbers.number[min(next[k], range.y - 1u)];
        number[k] = next[k] < end[k] ? ahead : 0xffffffffu;
      }
    }
    for (uint i = range.x; i < range.y; ++i) push.lists.numbers.number[i] = push.merged.number[i];
  }
}
