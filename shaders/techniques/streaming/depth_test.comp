#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sorts each pixel's fragments and puts them through the n-sample depth test in submission order; one invocation for each pixel.
// Reads: records, fragments. Writes: the sorted numbers, those that passed first; with each the samples that passed; the depths
// of the pixel's state.
layout(local_size_x = 64) in;
#include "techniques/streaming/streaming_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(push_constant, scalar) uniform Push { OrderedKeepPush push; };
#include "frontend/read_ahead.glsl"

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uvec2 range = list_range(push.lists, p);
  uint begin = range.x, end = range.y;
  sort_list(push.lists.numbers, begin, end);

  uvec4 depths[8];
  for (uint i = 0u; i < DEPTH_QUADS; ++i) depths[i] = uvec4(0u);
  uint kept = begin;
  for (bool go = begin < end; go; go = false) {
    ListEntry first = list_entry(begin, end), second = list_entry(begin + 1u, end);
    RecordDepth depth = record_depth(first.fragment.x);
    for (uint i = begin; i < end; ++i) {
      ListEntry own = first;
      DepthPlane plane = plane_of(depth, pixel);
      depth = record_depth(second.fragment.x);
      first = second;
      second = list_entry(i + 2u, end);
      uint passed = 0u;
      for (uint k = 0u; k < DEPTH_QUADS; ++k) {
        uvec4 before = depths[k];
        depths[k] = stream_nearer(before, SAMPLES, own.fragment.z, 4u * k, plane);
        passed |= stream_passed(before, depths[k], 4u * k);
      }
      if (passed != 0u) {
        push.lists.fragments.fragment[own.number].w = passed;
        push.lists.numbers.number[kept] = own.number;
        ++kept;
      }
    }
  }
  push.kept.count[p] = kept - begin;
  for (uint k = 0u; k < DEPTH_QUADS; ++k) push.state.quads[p * LISTED_STATE_QUADS + k] = depths[k];
}
