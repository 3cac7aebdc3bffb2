#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Exclusive prefix sums over chunks (or what else has four numbers each), in place, with the totals behind the last; one workgroup.
// Reads and writes: sums, one more entry than are scanned.
layout(local_size_x = 256) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) buffer Sums { uvec4 sums[]; };
layout(push_constant, scalar) uniform Push { ScanPush push; };

shared uvec4 block[256];

void main() {
  uint lane = gl_LocalInvocationID.x;
  uint share = (push.count + 255u) / 256u;
  uint first = min(lane * share, push.count), last = min(first + share, push.count);
  uvec4 sum = uvec4(0u);
  for (uint i = first; i < last; ++i) sum += sums[i];
  block[lane] = sum;
  barrier();
  if (lane == 0u) {
    uvec4 running = uvec4(0u);
    for (uint i = 0u; i < 256u; ++i) {
      uvec4 own = block[i];
      block[i] = running;
      running += own;
    }
    sums[push.count] = running;
  }
  barrier();
  uvec4 running = block[lane];
  for (uint i = first; i < last; ++i) {
    uvec4 own = sums[i];
    sums[i] = running;
    running += own;
  }
}
