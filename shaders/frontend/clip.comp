#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: COUNT=-DCOUNT EMIT=-DEMIT
// Clips the triangles of the list against the six planes (Sutherland and Hodgman 1974) and sets up the pieces as a fan.
// Reads: the list and what set-up reads. Writes: COUNT, the number of pieces; EMIT, their records behind all slots, where
// the scan of the counts put them.
layout(local_size_x = 64) in;
#include "frontend/setup.glsl"
#include "frontend/geometry.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CHUNKS), scalar) readonly buffer Chunks { ChunkRecord chunks[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COUNTS), scalar) buffer Counts { uint counts[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CLIP_LIST), scalar) readonly buffer ClipList { uint clip_slots[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CLIP_COUNT), scalar) readonly buffer ClipCount { uint clip_count; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_PIECE_BASES), scalar) readonly buffer PieceBases { uint piece_bases[]; };

const uint kMaxCorners = 9u;

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= clip_count) return;
  uint slot = clip_slots[item];
  ChunkRecord chunk = chunks[slot / SUBPIXEL_CHUNK_TRIANGLES];
  uint first_index = chunk.range.x + 3u * (slot % SUBPIXEL_CHUNK_TRIANGLES);
  vec4 c[3];
  clip_positions(first_index, chunk.range.z, c);

  vec4 corners[kMaxCorners], next[kMaxCorners];
  corners[0] = c[0];
  corners[1] = c[1];
  corners[2] = c[2];
  uint count = 3u;
  for (uint plane = 0u; plane < 6u; ++plane) {
    uint kept = 0u;
    for (uint k = 0u; k < count; ++k) {
      vec4 a = corners[k], b = corners[k + 1u < count ? k + 1u : 0u];
      float da = plane_distance(plane, a), db = plane_distance(plane, b);
      if (da >= 0.0 && kept < kMaxCorners) next[kept++] = a;
      if ((da >= 0.0) != (db >= 0.0) && kept < kMaxCorners) {
        // Always from the inside outwards, so that both triangles of an edge get the same corner.
        vec4 inside = da >= 0.0 ? a : b, outside = da >= 0.0 ? b : a;
        float di = max(da, db), d_o = min(da, db);
        next[kept++] = mix(inside, outside, di / (di - d_o));
      }
    }
    count = kept;
    for (uint k = 0u; k < kept; ++k) corners[k] = next[k];
  }

  bool cull_back = (chunk.flags.x & CHUNK_CULL_BACK) != 0u;
  bool mirrored = instance_mirrored(chunk.range.z);
  uint pieces = 0u;
  for (uint k = 2u; k < count; ++k) {
    TriangleRecord record;
    bool in_front = corners[0].w > 0.0 && corners[k - 1u].w > 0.0 && corners[k].w > 0.0;
    uint hull = set_up_triangle(corners[0], corners[k - 1u], corners[k], cull_back, mirrored, record);
    if (!in_front || hull == 0u) continue;
#ifdef EMIT
    // All pieces are drawn as two triangles, the second of which may be empty.
    if (hull == 1u) record.depth2.yz = record.hull01.xy;
    record.depth2.w = slot;
    record.hull2_id.zw = uvec2(first_index, chunk.range.z);
    record.v2_ref.w |= (mirrored ? RECORD_MIRRORED : 0u) | chunk.range.w << RECORD_MATERIAL_SHIFT;
    uint piece = piece_bases[slot] + pieces;
    if (piece < push.piece_capacity) push.records.record[push.triangle_slots + piece] = record;
#endif
    ++pieces;
  }
#ifdef COUNT
  // The top bit says that the records are pieces, behind the slots.
  counts[slot] = pieces | COUNT_CLIPPED;
#endif
}
