#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Counts fragments: 1 for each triangle and pixel of which it covers a sample, before depth and alpha.
// Reads: nothing but the triangle. Writes (additively): the pixel's count.
#include "frontend/fragment.glsl"

layout(location = 0) out float out_count;

void main() {
  PixelEdges edges = fragment_edges(pixel_of(gl_FragCoord.xy));
  uint covered = 0u;
  for (uint first = 0u; first < SAMPLES; first += 32u) covered |= coverage_mask(edges, SAMPLES, first, min(SAMPLES, 32u));
  if (covered == 0u) discard;
  out_count = 1.0;
}
