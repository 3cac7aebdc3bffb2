#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The masks of alpha-tested fragments, from what geometry covers to what alpha leaves.
// Reads: listed fragments. Writes: their masks.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/fragment.glsl"

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  load_fragment(fragment.x);
  ivec2 pixel = listed_pixel(fragment);
  PixelEdges edges = fragment_edges(pixel);
  uint geometry = coverage_mask(edges, SAMPLES, 0u, SAMPLES);
  lists.fragments.fragment[number].z = alpha_mask(geometry, 0u, SAMPLES, pixel, mask_offset(edges, geometry));
}
