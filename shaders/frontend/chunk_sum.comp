#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: ALL= REST=-DREST
// Sums the hulls' triangles, the clipped pieces and the screen triangles of each chunk; one invocation for each chunk.
// REST leaves the small ones out of the first sum.
// Reads: counts. Writes: sums (x: hulls' triangles, y: clipped pieces, z: screen
// triangles, pieces among them, w: small ones).
layout(local_size_x = 64) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COUNTS), scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) writeonly buffer Sums { uvec4 sums[]; };
layout(push_constant, scalar) uniform Push { ChunkSumPush push; };

void main() {
  uint chunk = gl_GlobalInvocationID.x;
  if (chunk >= push.chunk_count) return;
  uvec4 sum = uvec4(0u);
  for (uint k = 0u; k < SUBPIXEL_CHUNK_TRIANGLES; ++k) {
    uint slot = chunk * SUBPIXEL_CHUNK_TRIANGLES + k;
    uint count = counts[slot];
    bool clipped = (count & COUNT_CLIPPED) != 0u, small = (count & push.small_bits) != 0u;
    count &= COUNT_MASK;
    uint pieces = clipped ? count : 0u;
    uint records = clipped ? count : min(count, 1u);
    uint hull = clipped ? 2u : count;  // triangles of each record's hull
#ifdef REST
    hull = small ? 0u : hull;
#endif
    sum += uvec4(records * hull, pieces, records, small ? records : 0u);
  }
  sums[chunk] = sum;
}
