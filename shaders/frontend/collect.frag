#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: COUNT=-DCOUNT STORE=-DSTORE
// Fragments of the triangles that collect.comp leaves, into the same lists.
// Reads: the hulls' outputs; STORE, the bases, each of which it raises by the fragments stored. Writes: as collect.comp.
#include "frontend/fragment.glsl"
#include "frontend/fragment_lists.glsl"
#include "frontend/collect_fragment.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_LISTS), scalar) readonly buffer Lists { ListAddresses lists; };

void main() {
  // Of the whole frame: rasterised as without bands, for lists may have all pixels of a hull that edges reach.
  ivec2 pixel = pixel_of(gl_FragCoord.xy) - frame_pixel(ivec2(0));
  uint mask = listed_mask(fragment_edges(pixel));
  // Devices shade whole blocks: pixels beyond the border have no list.
  bool inside = all(lessThan(pixel, band_size())) && pixel.y >= 0;
  for (bool go = mask != 0u && inside; go; go = false) {
    ListAddresses to = lists;
    uint width = uint(frame.viewport.x), number = atomicAdd(to.bases.base[fragment_triangle()], 1u);
#ifdef COUNT
    collect_count(to, pixel, width);
#else
    collect_store(to, number, fragment_triangle(), pixel, mask, width);
#endif
  }
}
