#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: OPAQUE= ALPHA=-DWITH_UV
// For the maps: what covers a pixel at all, and what the table decides otherwise than exact edges do.
// Writes: by atomic operations, which know no order. Of each pixel, xy: samples that some fragment covers; z: sample decisions of
// its fragments; w: those that the table gets wrong.
#include "techniques/dcaa/fragment_mask.glsl"
#include "techniques/dcaa/found.glsl"

void main() {
  // Of the whole frame: rasterised as without bands, for the table also counts where only a hull reaches.
  ivec2 pixel = pixel_of(gl_FragCoord.xy) - frame_pixel(ivec2(0));
  PixelEdges edges = fragment_edges(pixel);
  uvec2 exact = exact_coverage(edges), table = table_coverage(edges);
  uvec2 mask = fragment_coverage(edges);
#ifdef WITH_UV
  for (bool go = mask != uvec2(0u); go; go = false) mask = alpha_coverage(mask, pixel, mask_shading_offset(edges, mask));
#endif
  // Devices shade whole blocks: pixels beyond the border have no words.
  bool counts = (exact | table) != uvec2(0u) && all(lessThan(pixel, band_size())) && pixel.y >= 0;
  if (counts) {
    uint at = found_word(pixel);
    atomicOr(found.words.word[at], mask.x);
    atomicOr(found.words.word[at + 1u], mask.y);
    atomicAdd(found.words.word[at + 2u], SAMPLES);
    atomicAdd(found.words.word[at + 3u], dcaa_count(exact ^ table));
  }
}
