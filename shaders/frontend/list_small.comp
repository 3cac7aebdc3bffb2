#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: COUNT=-DCOUNT STORE=-DSTORE
// Small triangles into lists by block of 4x2 pixels; one invocation for each triangle. A list's order varies from run to run.
// Reads: the records' numbers; COUNT, the records; STORE, the small triangles and where each block's list begins.
// Writes: COUNT, the small triangles, side by side, and how many each block has; STORE, the lists, of places among the
// small triangles, and where each ends.
layout(local_size_x = 64) in;
#include "frontend/buffers.glsl"
#include "include/coverage.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SMALL_RECORDS), scalar) readonly buffer SmallRecords { uint small_records[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer SmallTriangles { SmallTriangle at[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_BLOCK_ENDS), scalar) buffer BlockEnds { uint block_end[]; };
#ifdef STORE
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_BLOCK_LISTS), scalar) writeonly buffer BlockLists { uint listed[]; };
#endif
layout(push_constant, scalar) uniform Push { ListSmallPush push; };

#define WALK_CELL kBlockCell
#include "frontend/small_triangles.glsl"

uint item;

void visit(ivec2 block, PixelEdges edges) {
  uint place = atomicAdd(block_end[uint(block.y) * blocks_in_row(push.width) + uint(block.x)], 1u);
#ifdef STORE
  listed[place] = item;
#endif
}
#include "frontend/small_walk.glsl"

void main() {
  item = dealt_item();
  if (item >= push.count) return;
#ifdef COUNT
  uint record = small_records[item];
  uvec4 v01 = push.records.record[record].v01, v2_ref = push.records.record[record].v2_ref;
  push.small.at[item] = SmallTriangle(v01, v2_ref, push.records.record[record].depth,
                              uvec4(push.records.record[record].depth2.x, record, 0u, 0u));
#else
  uvec4 v01 = push.small.at[item].v01, v2_ref = push.small.at[item].v2_ref;
#endif
  walk_small_triangle(ivec2(v01.xy), ivec2(v01.zw), ivec2(v2_ref.xy), uvec2(push.width, push.height));
}
