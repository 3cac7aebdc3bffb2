#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sets up every triangle of the frame: one workgroup for each chunk, one invocation for each triangle.
// Reads: chunks, instance clip matrices, indices, positions. Writes: the record at the triangle's own slot and how many
// triangles its hull has, with COUNT_ bits; triangles that cross a clip plane go to the list of the clipping pass.
layout(local_size_x = 64) in;
#include "frontend/setup.glsl"
#include "frontend/geometry.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CHUNKS), scalar) readonly buffer Chunks { ChunkRecord chunks[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COUNTS), scalar) writeonly buffer Counts { uint counts[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CLIP_LIST), scalar) writeonly buffer ClipList { uint clip_slots[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_CLIP_COUNT), scalar) buffer ClipCount { uint clip_count; };

void main() {
  uint chunk_index = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
  if (chunk_index >= push.chunk_count) return;
  ChunkRecord chunk = chunks[chunk_index];
  uint lane = gl_LocalInvocationID.x;
  uint slot = chunk_index * SUBPIXEL_CHUNK_TRIANGLES + lane;
  if (lane >= chunk.range.y) {
    counts[slot] = 0u;
    return;
  }
  uint first_index = chunk.range.x + 3u * lane;
  vec4 c[3];
  clip_positions(first_index, chunk.range.z, c);

  uint outside_any = 0u, outside_all = 63u;
  bool finite = true;
  for (uint k = 0u; k < 3u; ++k) {
    uint code = 0u;
    for (uint plane = 0u; plane < 6u; ++plane) code |= plane_distance(plane, c[k]) >= 0.0 ? 0u : 1u << plane;
    // A vertex at the eye's plane has no screen position whatever the planes say.
    code |= c[k].w > 0.0 ? 0u : 64u;
    outside_any |= code;
    outside_all &= code;
    finite = finite && !any(isnan(c[k])) && !any(isinf(c[k]));
  }
  bool visible = finite && outside_all == 0u;
  bool whole = visible && outside_any == 0u;
  uint count = 0u;
  if (whole) {
    TriangleRecord record;
    bool cull_back = (chunk.flags.x & CHUNK_CULL_BACK) != 0u;
    bool mirrored = instance_mirrored(chunk.range.z);
    count = set_up_triangle(c[0], c[1], c[2], cull_back, mirrored, record);
    // Pieces of clipped triangles stay in every band: their numbers count those before them.
    if (count != 0u && !in_band(record)) count = 0u;
    record.hull2_id.zw = uvec2(first_index, chunk.range.z);
    record.v2_ref.w |= (mirrored ? RECORD_MIRRORED : 0u) | chunk.range.w << RECORD_MATERIAL_SHIFT;
    record.depth2.w = slot;
    if (count != 0u) push.records.record[slot] = record;
    bool small = (record.v2_ref.w & RECORD_LARGE) == 0u && pixels_reached(record) <= SUBPIXEL_SMALL_TRIANGLE_PX;
    uint kind = (chunk.flags.x & CHUNK_ALPHA_TEST) == 0u ? COUNT_SMALL : COUNT_SMALL_TESTED;
    count |= count != 0u && small ? kind | blocks_reached(record) << COUNT_BLOCKS_SHIFT : 0u;
  }
  if (visible && !whole) {
    clip_slots[atomicAdd(clip_count, 1u)] = slot;
  }
  counts[slot] = count;
}
