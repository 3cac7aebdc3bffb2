#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The masks of fragments whose mask takes textures or long loops, one an invocation.
// Reads: listed fragments. Writes: their masks; kNothing for those that keep no sample.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#define LISTED
#include "techniques/dcaa/fragment_mask.glsl"
#include "frontend/listed_fragment.glsl"
#include "techniques/dcaa/listed.glsl"

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  load_fragment(fragment.x);
  ivec2 pixel = listed_pixel(fragment);
  PixelEdges edges = fragment_edges(pixel);
  uvec2 mask = fragment_coverage(edges);
  bool tested = has_feature(FEATURE_ALPHA_TEST) && (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
  for (bool go = tested && mask != uvec2(0u); go; go = false) mask = alpha_coverage(mask, pixel, mask_shading_offset(edges, mask));
  lists.fragments.fragment[number] = uvec4(mask == uvec2(0u) ? kNothing : fragment.x, fragment.y, mask);
}
