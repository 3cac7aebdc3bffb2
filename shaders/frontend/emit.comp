#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: ALL= REST=-DREST
// Writes the index buffer of the hulls in submission order and where each clipped triangle's pieces go; one invocation
// for each chunk.
// REST leaves out the small ones, which it lists.
// Reads: counts, scanned sums. Writes: hull indices (4 * record + corner); ALL, piece bases; REST, the
// records of the small triangles.
layout(local_size_x = 64) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COUNTS), scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) readonly buffer Sums { uvec4 sums[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_HULL_INDICES), scalar) writeonly buffer Hulls { uint hull_indices[]; };
#ifdef REST
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_PIECE_BASES), scalar) readonly buffer PieceBases { uint piece_bases[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SMALL_RECORDS), scalar) writeonly buffer SmallRecords { uint small_records[]; };
#else
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_PIECE_BASES), scalar) writeonly buffer PieceBases { uint piece_bases[]; };
#endif
layout(push_constant, scalar) uniform Push { EmitPush push; };

void main() {
  uint chunk = gl_GlobalInvocationID.x;
  if (chunk >= push.chunk_count) return;
  uint out_hull = sums[chunk].x, out_piece = sums[chunk].y, out_small = sums[chunk].w;
  for (uint k = 0u; k < SUBPIXEL_CHUNK_TRIANGLES; ++k) {
    uint slot = chunk * SUBPIXEL_CHUNK_TRIANGLES + k;
    uint count = counts[slot];
    bool clipped = (count & COUNT_CLIPPED) != 0u, small = (count & push.small_bits) != 0u;
    count &= COUNT_MASK;
    uint pieces = clipped ? count : min(count, 1u);
    uint hull = clipped ? 2u : count;
#ifdef REST
    if (clipped) out_piece = piece_bases[slot];
#else
    if (clipped) piece_bases[slot] = out_piece;
#endif
    for (uint piece = 0u; piece < pieces; ++piece) {
      uint record = clipped ? push.triangle_slots + out_piece + piece : slot;
#ifdef REST
      if (small) {
        if (out_small < push.small_capacity) small_records[out_small] = record;
        ++out_small;
        continue;
      }
#endif
      for (uint t = 0u; t < hull; ++t) {
        if (out_hull < push.hull_capacity) {
          hull_indices[3u * out_hull] = 4u * record;
          hull_indices[3u * out_hull + 1u] = 4u * record + 1u + t;
          hull_indices[3u * out_hull + 2u] = 4u * record + 2u + t;
        }
        ++out_hull;
      }
    }
    out_piece += clipped ? pieces : 0u;
  }
}
