#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The fragments of a frame as they come to the streaming compression: each by itself, nothing of other fragments known.
// Reads: listed fragments, whose masks it makes anew. Writes: a StreamTestFragment for each.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/fragment.glsl"
#include "tests/streaming_test_interface.h"

layout(set = 0, binding = STORAGE(STREAM_TEST_SLOT_OF_FRAME), scalar) writeonly buffer Stream {
  StreamTestFragment stream[];
};

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 listed = lists.fragments.fragment[number];
  load_fragment(listed.x);
  ivec2 pixel = listed_pixel(listed);
  PixelEdges edges = fragment_edges(pixel);
  uint geometry = coverage_mask(edges, SAMPLES, 0u, SAMPLES), mask = geometry;
  bool tested = has_feature(FEATURE_ALPHA_TEST) && (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
  for (bool go = tested; go; go = false)
    mask = alpha_mask(geometry, 0u, SAMPLES, pixel, mask_offset(edges, geometry));
  DepthPlane plane = fragment_depth(pixel);
  StreamSurface s = stream_fragment(pixel, edges, plane, geometry);
  StreamTestFragment fragment;
  fragment.plane = vec4(plane.centre, plane.dx, plane.dy, plane.smallest);
  fragment.depth = vec4(s.depth, 0.0, 0.0, plane.largest);
  fragment.words = uvec4(mask, s.albedo, s.normal, s.roughness);
  fragment.more = uvec4(s.emission, s.slopes, listed.y, 0u);
  stream[number] = fragment;
}
