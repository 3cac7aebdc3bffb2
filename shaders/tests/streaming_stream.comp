#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The streaming compression fed with a stream of its own: one invocation compresses one pixel.
// Reads: ranges, first fragment and count of each pixel; fragments. Writes: the pixel's state as compress.frag leaves it.
layout(local_size_x = 64) in;
#include "tests/streaming_test_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"

layout(set = 0, binding = STORAGE(STREAM_TEST_SLOT_RANGES), scalar) readonly buffer Ranges { uvec2 ranges[]; };
layout(set = 0, binding = STORAGE(STREAM_TEST_SLOT_FRAGMENTS), scalar) readonly buffer Stream {
  StreamTestFragment fragments[];
};
layout(set = 0, binding = STORAGE(STREAM_TEST_SLOT_QUADS), scalar) writeonly buffer Quads { uvec4 quads[]; };

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= uint(ranges.length())) return;
  uvec4 depths[8];
  for (uint i = 0u; i < DEPTH_QUADS; ++i) depths[i] = uvec4(0u);
  uint word = 0u;
  StreamSurface surface[STREAM_MAX_SURFACES];
  for (uint i = 0u; i < STREAM_MAX_SURFACES; ++i) surface[i] = StreamSurface(0.0, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  for (uint k = 0u; k < ranges[pixel].y; ++k) {
    StreamTestFragment given = fragments[ranges[pixel].x + k];
    DepthPlane plane = DepthPlane(given.plane.x, given.plane.y, given.plane.z, given.plane.w, given.depth.w);
    uint passed = 0u;
    for (uint i = 0u; i < DEPTH_QUADS; ++i) {
      uvec4 before = depths[i];
      depths[i] = stream_nearer(before, SAMPLES, given.words.x, 4u * i, plane);
      passed |= stream_passed(before, depths[i], 4u * i);
    }
    for (bool go = passed != 0u; go; go = false) {
      StreamSurface fragment;
      fragment.depth = given.depth.x;
      fragment.slopes = stream_pack_slopes(given.depth.yz);
      fragment.coverage = given.words.x;
      fragment.resolved = stream_option(STREAM_DEPTH_TESTED) ? passed : given.words.x;
      fragment.albedo = given.words.y;
      fragment.normal = given.words.z;
      fragment.roughness = given.words.w;
      fragment.emission = given.more.x;
      stream_add(word, surface, fragment);
    }
  }
  StreamList list;
  stream_pack(word, surface, list);
  for (uint i = 0u; i < DEPTH_QUADS; ++i) quads[pixel * LISTED_STATE_QUADS + i] = depths[i];
  for (uint i = 0u; i < LIST_QUADS; ++i) quads[pixel * LISTED_STATE_QUADS + DEPTH_QUADS + i] = QUAD_OF(list.word, i);
}
