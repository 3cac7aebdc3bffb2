#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: OPAQUE= ALPHA=-DWITH_UV
// For the maps: what covers a pixel at all, and what the table decides otherwise than exact edges do.
// Reads and writes: the attachment, in primitive order. xy: samples that some fragment covers; z: sample decisions of the
// pixel's fragments; w: those that the table gets wrong.
#include "techniques/dcaa/fragment_mask.glsl"

layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in_found;
layout(location = 0) out uvec4 out_found;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  PixelEdges edges = fragment_edges(pixel);
  uvec2 exact = exact_coverage(edges), table = table_coverage(edges);
  uvec2 mask = fragment_coverage(edges);
#ifdef WITH_UV
  for (bool go = mask != uvec2(0u); go; go = false) mask = alpha_coverage(mask, pixel, mask_shading_offset(edges, mask));
#endif
  bool counts = (exact | table) != uvec2(0u);
  for (bool go = counts; go; go = false) {
    uvec4 found = subpassLoad(in_found);
    out_found = uvec4(found.xy | mask, found.z + SAMPLES, found.w + dcaa_count(exact ^ table));
  }
  if (!counts) discard;
}
