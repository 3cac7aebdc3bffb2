#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sorts each pixel's fragments and puts them through the n-sample depth test in submission order; one invocation for each pixel.
// Reads: records, fragments. Writes: the sorted numbers, those that passed first; with each the samples that passed; the depths
// of the pixel's state.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SAMPLES = 8u;
#include "frontend/fragment_lists.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "techniques/streaming/listed.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer StateQuads { uvec4 quads[]; };
layout(push_constant, scalar) uniform Push {
  ListAddresses lists;
  Records records;
  StateQuads state;
  PassedCounts passed;
  uint width, height;
} push;

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
  for (uint i = begin; i < end; ++i) {
    uint number = push.lists.numbers.number[i];
    uvec4 fragment = push.lists.fragments.fragment[number];
    uvec4 depth = push.records.record[fragment.x].depth;
    uint depth2 = push.records.record[fragment.x].depth2.x, reference = push.records.record[fragment.x].v2_ref.z;
    DepthPlane plane = depth_plane(depth, depth2, ivec2(reference & 0xffffu, reference >> 16), pixel);
    uint passed = 0u;
    for (uint k = 0u; k < DEPTH_QUADS; ++k) {
      uvec4 before = depths[k];
      depths[k] = stream_nearer(before, SAMPLES, fragment.z, 4u * k, plane);
      passed |= stream_passed(before, depths[k], 4u * k);
    }
    if (passed != 0u) {
      push.lists.fragments.fragment[number].w = passed;
      push.lists.numbers.number[kept] = number;
      ++kept;
    }
  }
  push.passed.passed[p] = kept - begin;
  for (uint k = 0u; k < DEPTH_QUADS; ++k) push.state.quads[p * STATE_QUADS + k] = depths[k];
}
