#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: COUNT=-DCOUNT STORE=-DSTORE
// The visible fragments of each pixel into lists, one for each triangle that it shows; one invocation for each pixel.
// Reads: visibility; STORE, the bases, each of which it raises by the fragments stored, and the pixels' bases.
// Writes: COUNT, how many fragments each pixel and each record has; STORE, the fragments and their numbers, and the pixels' ends.
layout(local_size_x = 64) in;
#include "frontend/fragment_lists.glsl"
#include "include/visibility.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(push_constant, scalar) uniform Push { VisibleFragmentsPush push; };

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uvec2 all = uvec2(0xffffffffu >> (32u - min(SAMPLES, 32u)), SAMPLES == 64u ? 0xffffffffu : 0u);
  uvec2 left = all & ~samples_showing(pixel, SAMPLES, SUBPIXEL_NO_TRIANGLE);
#ifdef COUNT
  uint place = 0u;
#else
  uint place = push.lists.ends.end[p];
#endif
  while ((left.x | left.y) != 0u) {
    uint s = left.x != 0u ? uint(findLSB(left.x)) : 32u + uint(findLSB(left.y));
    uint record = visible_triangle(pixel, SAMPLES, s);
    uvec2 shown = samples_showing(pixel, SAMPLES, record);
    left &= ~shown;
    uint number = atomicAdd(push.lists.bases.base[record], 1u);
#ifdef STORE
    push.lists.fragments.fragment[number] = uvec4(record, uint(pixel.x) | uint(pixel.y) << 16, shown);
    push.lists.numbers.number[place] = number;
#endif
    ++place;
  }
  push.lists.ends.end[p] = place;
}
