#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16
// Visibility of small triangles: one invocation walks the pixels of one triangle. The device's rasteriser hands 4x4 blocks to
// fragment shaders, of which a triangle of a few pixels fills little; here all lanes have a pixel of a triangle of their own.
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
  uint stride;  // has no factor in common with the number of groups
  uint width, height;
} push;

// Narrows [first, last] to the pixels of a row that one edge's half plane, widened by a pixel's samples, reaches. `edge`: the
// edge function at the centre of pixel `origin`; `step`: what a pixel to the right adds. Floats are exact enough: rows are
// short, and a pixel too many is only tested.
void narrow_row(int edge, int step, int origin, inout int first, inout int last) {
  float crossing = float(-edge) / float(step);
  if (step > 0) first = max(first, origin + int(ceil(crossing - 0.01)));
  if (step < 0) last = min(last, origin + int(floor(crossing + 0.01)));
  if (step == 0 && edge < 0) last = first - 1;
}

void main() {
  // A device that gives each thread a run of groups would give one all the large triangles: they stand together.
  uint item = gl_WorkGroupID.x * push.stride % gl_NumWorkGroups.x * 64u + gl_LocalInvocationID.x;
  if (item >= push.count) return;
  uint number = small_records[item];
  uvec4 v01 = push.records.record[number].v01;
  uvec4 v2_ref = push.records.record[number].v2_ref;
  uvec4 depth = push.records.record[number].depth;
  uint depth2 = push.records.record[number].depth2.x;
  ivec2 v0 = ivec2(v01.xy), v1 = ivec2(v01.zw), v2 = ivec2(v2_ref.xy);
  ivec2 reference = ivec2(v2_ref.z & 0xffffu, v2_ref.z >> 16);
  // As set-up's bounds: a sample is less than half a pixel (and 1/128) from its pixel's centre.
  ivec2 low = min(min(v0, v1), v2), high = max(max(v0, v1), v2);
  ivec2 first = max((low - 1) >> 8, ivec2(0)), last = min((high + 1) >> 8, ivec2(push.width, push.height) - 1);
  ivec2 origin = first * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2;
  ivec2 along[3] = ivec2[3](v1 - v0, v2 - v1, v0 - v2), from[3] = ivec2[3](v0, v1, v2);

  // Edge functions at the centre of the row's pixel first.x; all within 32 bits for small triangles (coverage.glsl).
  int row[3], step_x[3], step_y[3], reach[3];
  PixelEdges edges;
  for (uint k = 0u; k < 3u; ++k) {
    ivec2 away = origin - from[k];
    row[k] = along[k].x * away.y - along[k].y * away.x - (edge_inclusive(along[k]) ? 0 : 1);
    step_x[k] = -along[k].y * SUBPIXEL_SNAP;
    step_y[k] = along[k].x * SUBPIXEL_SNAP;
    reach[k] = (abs(along[k].x) + abs(along[k].y)) * (SUBPIXEL_SNAP / 2);
    edges.a[k] = -float(along[k].y);
    edges.b[k] = float(along[k].x);
    row[k] -= step_y[k];
  }
  ivec2 pixel = ivec2(first.x, first.y - 1);
  int row_end = first.x - 1;
  // Every turn is a pixel; the rows' ends are found on the way, so that lanes do not wait for each other's rows.
  while (true) {
    if (pixel.x > row_end) {
      ++pixel.y;
      if (pixel.y > last.y) break;
      pixel.x = first.x;
      row_end = last.x;
      for (uint k = 0u; k < 3u; ++k) {
        row[k] += step_y[k];
        narrow_row(row[k] + reach[k], step_x[k], first.x, pixel.x, row_end);
      }
    }
    if (pixel.x <= row_end) {
      for (uint k = 0u; k < 3u; ++k)
        edges.base[k] = float(clamp((row[k] + (pixel.x - first.x) * step_x[k]) >> 1, -8388608, 8388608));
      DepthPlane plane = depth_plane(depth, depth2, reference, pixel);
      uint base = (uint(pixel.y) * push.width + uint(pixel.x)) * GROUP;
      for (uint i = 0u; i < GROUP; ++i) {
        ivec2 offset = sample_offset(SAMPLES, SAMPLE_GROUP * GROUP + i);
        uint z = floatBitsToUint(sample_depth(plane, offset));
        if (small_covers(edges, offset) && z != 0u)
          atomicMax(push.keys.key[base + i], packUint2x32(uvec2(~number, z)));
      }
      ++pixel.x;
    }
  }
}
