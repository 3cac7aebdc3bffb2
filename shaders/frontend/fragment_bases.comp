#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: SUM=-DSUM BASE=-DBASE
// From how many fragments each record has to the number of its first one, in submission order; one invocation for each chunk.
// SUM adds up a chunk's, BASE gives each record its base once the sums are scanned.
// Reads: counts of set-up, piece bases. Reads and writes: the records' counts or bases, the chunks' sums (x), SUM, how many
// of their records have any (y).
layout(local_size_x = 64) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COUNTS), scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) buffer Sums { uvec4 sums[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_PIECE_BASES), scalar) readonly buffer PieceBases { uint piece_bases[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_FRAGMENT_BASES), scalar) buffer Bases { uint bases[]; };
layout(push_constant, scalar) uniform Push { FragmentBasesPush push; };

void main() {
  uint chunk = gl_GlobalInvocationID.x;
  if (chunk >= push.chunk_count) return;
#ifdef SUM
  uint running = 0u, seen = 0u;
#else
  uint running = sums[chunk].x;
#endif
  for (uint k = 0u; k < SUBPIXEL_CHUNK_TRIANGLES; ++k) {
    uint slot = chunk * SUBPIXEL_CHUNK_TRIANGLES + k;
    uint count = counts[slot];
    bool clipped = (count & COUNT_CLIPPED) != 0u;
    uint records = clipped ? count & COUNT_MASK : min(count & COUNT_MASK, 1u);
    uint first = clipped ? push.triangle_slots + piece_bases[slot] : slot;
    for (uint i = 0u; i < records; ++i) {
      uint own = bases[first + i];
#ifdef BASE
      bases[first + i] = running;
#else
      seen += min(own, 1u);
#endif
      running += own;
    }
  }
#ifdef SUM
  sums[chunk] = uvec4(running, seen, 0u, 0u);
#endif
}
