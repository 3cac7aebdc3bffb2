#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// What the front-end gives for each fragment of one pixel: masks, depths, attributes.
// Reads: listed fragments, records, the source triangles' vertices, materials. Writes: what is found.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "frontend/collect_fragment.glsl"
#include "include/packing.glsl"
#include "story/story_interface.h"

layout(set = 0, binding = STORAGE(STORY_SLOT_FRAGMENTS), scalar) writeonly buffer Found { StoryFragment found[]; };

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  load_fragment(fragment.x);
  ivec2 pixel = listed_pixel(fragment);
  PixelEdges edges = fragment_edges(pixel);
  DepthPlane plane = fragment_depth(pixel);
  const uint low = min(SAMPLES, 32u), high = SAMPLES - low;
  uvec2 geometry =
      uvec2(coverage_mask(edges, SAMPLES, 0u, low), high > 0u ? coverage_mask(edges, SAMPLES, 32u, 32u) : 0u);
  vec2 offset = shading_offset(edges, SAMPLES);
  uvec2 left = geometry;
  if (has_feature(FEATURE_ALPHA_TEST)) {
    bool tested = (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
    for (bool go = tested; go; go = false)
      left = uvec2(alpha_mask(geometry.x, 0u, low, pixel, offset),
                   high > 0u ? alpha_mask(geometry.y, 32u, 32u, pixel, offset) : 0u);
  }
  found[number].masks = uvec4(geometry, left);
  found[number].plane = vec4(plane.centre, plane.dx, plane.dy, plane.smallest);
  found[number].more = vec4(plane.largest, offset, listed_mask(edges) != 0u ? 1.0 : 0.0);
  found[number].surface = pack_surface(fragment_surface(pixel, offset));
  for (uint i = 0u; i < SAMPLES; ++i) found[number].depths[i] = sample_depth(plane, sample_offset(SAMPLES, i));
}
