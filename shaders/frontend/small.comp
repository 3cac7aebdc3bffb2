#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16
// Visibility of small triangles: one invocation walks the pixels of one triangle (small_walk.glsl).
// Reads: records. Writes: keys of GROUP samples a pixel, by atomic maximum, so that the order of invocations does not matter.
layout(local_size_x = 64) in;
#include "include/coverage.glsl"

layout(constant_id = 0) const uint SAMPLES = 8u;
layout(constant_id = 4) const uint SAMPLE_GROUP = 0u;
layout(set = 0, binding = 1, scalar) readonly buffer SmallRecords { uint small_records[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
// Depth bits above, complement of the triangle below: the maximum is the nearest triangle, of equal ones the first submitted,
// since small triangles are whole and have the records of their slots. 0 where nothing covers the sample.
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer SampleKeys { uint64_t key[]; };
layout(push_constant, scalar) uniform Push {
  Records records;
  SampleKeys keys;
  uint count;
  uint groups, runs;  // dealt_item()
  uint width, height;
} push;

uint number;
uvec4 depth;
uint depth2;
ivec2 reference;

void visit(ivec2 pixel, PixelEdges edges) {
  DepthPlane plane = depth_plane(depth, depth2, reference, pixel);
  uint base = (uint(pixel.y) * push.width + uint(pixel.x)) * GROUP;
  for (uint i = 0u; i < GROUP; ++i) {
    ivec2 offset = sample_offset(SAMPLES, SAMPLE_GROUP * GROUP + i);
    uint z = floatBitsToUint(sample_depth(plane, offset));
    if (small_covers(edges, offset) && z != 0u)
      atomicMax(push.keys.key[base + i], packUint2x32(uvec2(~number, z)));
  }
}
#include "frontend/small_walk.glsl"

void main() {
  uint item = dealt_item(push.groups, push.runs);
  if (item >= push.count) return;
  number = small_records[item];
  uvec4 v01 = push.records.record[number].v01;
  uvec4 v2_ref = push.records.record[number].v2_ref;
  depth = push.records.record[number].depth;
  depth2 = push.records.record[number].depth2.x;
  reference = ivec2(v2_ref.z & 0xffffu, v2_ref.z >> 16);
  walk_small_triangle(ivec2(v01.xy), ivec2(v01.zw), ivec2(v2_ref.xy), uvec2(push.width, push.height));
}
