#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// variants: ALL= VISIBLE=-DVISIBLE
// Sums the hulls' triangles, the clipped pieces and the screen triangles of each chunk; one invocation for each chunk.
// VISIBLE counts those that own a sample.
// Reads: counts; VISIBLE, the flags and the piece bases. Writes: sums (x: hulls' triangles, y: clipped pieces, z: screen
// triangles, pieces among them).
layout(local_size_x = 64) in;
#include "frontend/frontend_types.h"

layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Sums { uvec3 sums[]; };
#ifdef VISIBLE
layout(set = 0, binding = 4, scalar) readonly buffer PieceBases { uint piece_bases[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Visible { uint visible[]; };
#endif
layout(push_constant, scalar) uniform Push {
  uint chunk_count;
  uint triangle_slots;
} push;

void main() {
  uint chunk = gl_GlobalInvocationID.x;
  if (chunk >= push.chunk_count) return;
  uvec3 sum = uvec3(0u);
  for (uint k = 0u; k < SUBPIXEL_CHUNK_TRIANGLES; ++k) {
    uint slot = chunk * SUBPIXEL_CHUNK_TRIANGLES + k;
    uint count = counts[slot];
    bool clipped = count > 0x7fffffffu;
    uint pieces = clipped ? count & 0x7fffffffu : 0u;
    uint records = clipped ? pieces : min(count, 1u);
    uint hull = clipped ? 2u : count;  // triangles of each record's hull
#ifdef VISIBLE
    uint seen = 0u;
    uint first = clipped ? push.triangle_slots + piece_bases[slot] : slot;
    for (uint piece = 0u; piece < records; ++piece) seen += visible[first + piece];
    records = seen;
#endif
    sum += uvec3(records * hull, pieces, records);
  }
  sums[chunk] = sum;
}
