#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Exclusive prefix sums over chunks (or what else has four numbers each), in place, with the totals behind the last; one workgroup.
// Reads and writes: sums, chunk_count + 1 entries.
layout(local_size_x = 256) in;
layout(set = 0, binding = 1, scalar) buffer Sums { uvec4 sums[]; };
layout(push_constant, scalar) uniform Push { uint chunk_count; } push;

shared uvec4 block[256];

void main() {
  uint lane = gl_LocalInvocationID.x;
  uint share = (push.chunk_count + 255u) / 256u;
  uint first = min(lane * share, push.chunk_count), last = min(first + share, push.chunk_count);
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
    sums[push.chunk_count] = running;
  }
  barrier();
  uvec4 running = block[lane];
  for (uint i = first; i < last; ++i) {
    uvec4 own = sums[i];
    sums[i] = running;
    running += own;
  }
}
