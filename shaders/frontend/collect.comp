#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: COUNT=-DCOUNT STORE=-DSTORE
// Fragments of small triangles into lists; one invocation for each triangle.
// Reads: small triangles, records; STORE, the bases. Writes: COUNT, how many fragments each pixel and each record has; STORE,
// the fragments and their numbers.
layout(local_size_x = 64) in;
#include "include/coverage.glsl"
#include "frontend/buffers.glsl"
#include "frontend/fragment_lists.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SMALL_RECORDS), scalar) readonly buffer SmallRecords { uint small_records[]; };
layout(push_constant, scalar) uniform Push { CollectPush push; };
#include "frontend/collect_fragment.glsl"

uint record, fragments, base;

void visit(ivec2 pixel, PixelEdges edges) {
  uint mask = listed_mask(edges);
  if (mask != 0u) {
#ifdef COUNT
    collect_count(push.lists, pixel, push.width);
#else
    collect_store(push.lists, base + fragments, record, pixel, mask, push.width);
#endif
    ++fragments;
  }
}
#include "frontend/small_walk.glsl"

void main() {
  uint item = dealt_item();
  if (item >= push.count) return;
  record = small_records[item];
  uvec4 v01 = push.records.record[record].v01;
  uvec2 v2 = push.records.record[record].v2_ref.xy;
  fragments = 0u;
#ifdef STORE
  base = push.lists.bases.base[record];
#endif
  walk_small_triangle(ivec2(v01.xy), ivec2(v01.zw), ivec2(v2), uvec2(push.width, push.height));
#ifdef COUNT
  push.lists.bases.base[record] = fragments;
#endif
}
