#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sums the screen triangles and the clipped pieces of each chunk; one invocation for each chunk.
// Reads: counts. Writes: sums (x: screen triangles, y: pieces among them).
layout(local_size_x = 64) in;
#include "frontend/frontend_types.h"

layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Sums { uvec2 sums[]; };
layout(push_constant, scalar) uniform Push { uint chunk_count; } push;

void main() {
  uint chunk = gl_GlobalInvocationID.x;
  if (chunk >= push.chunk_count) return;
  uvec2 sum = uvec2(0u);
  for (uint k = 0u; k < SUBPIXEL_CHUNK_TRIANGLES; ++k) {
    uint count = counts[chunk * SUBPIXEL_CHUNK_TRIANGLES + k];
    uint pieces = count & 0x7fffffffu;
    sum += uvec2(pieces, count > 0x7fffffffu ? pieces : 0u);
  }
  sums[chunk] = sum;
}
