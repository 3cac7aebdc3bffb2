#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: DEPTH=-DDEPTH SLOT=-DSLOT RECORD= DEPTHA=-DDEPTH,-DWITH_UV SLOTA=-DSLOT,-DWITH_UV RECORDA=-DWITH_UV
// Nearest triangle of each sample where the device promises no order of fragments: three passes over the geometry, each of atomic
// operations that no order changes. DEPTH: the nearest depth. SLOT: of the fragments that have it, the first submitted triangle.
// RECORD: of that one's pieces, the first. Leaves what nearest_samples.glsl does; variants A of alpha-tested materials.
// Reads and writes: the words of `nearest`, GROUP_SAMPLES a pixel.
#include "frontend/fragment.glsl"
#include "frontend/nearest_words.glsl"

layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;
layout(constant_id = CONSTANT_GROUP_SAMPLES) const uint GROUP_SAMPLES = 8u;
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_NEAREST), scalar) readonly buffer Nearest { NearestAddresses nearest; };

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  PixelEdges edges = fragment_edges(pixel);
  uint first = SAMPLE_GROUP * GROUP_SAMPLES;
  uint mask = coverage_mask(edges, SAMPLES, first, GROUP_SAMPLES);
#ifdef WITH_UV
  for (bool go = mask != 0u; go; go = false) mask = alpha_mask(mask, first, GROUP_SAMPLES, pixel, shading_offset(edges, SAMPLES));
#endif
  // Devices shade whole blocks: pixels beyond the border have no words.
  if (any(greaterThanEqual(pixel, band_size()))) mask = 0u;
  DepthPlane plane = fragment_depth(pixel);
  NearestAddresses to = nearest;
  uint at = (uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)) * GROUP_SAMPLES;
  while (mask != 0u) {
    uint i = uint(findLSB(mask));
    mask &= mask - 1u;
    // Reversed depths are not negative, so their bits compare like the numbers; 0 is the background's.
    uint z = floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, first + i)));
#ifdef DEPTH
    atomicMax(to.depths.word[at + i], z);
#else
    bool shows = z != 0u && to.depths.word[at + i] == z;
#ifdef SLOT
    if (shows) atomicMin(to.slots.word[at + i], fragment_slot());
#else
    if (shows && to.slots.word[at + i] == fragment_slot()) atomicMin(to.records.word[at + i], fragment_triangle());
#endif
#endif
  }
}
