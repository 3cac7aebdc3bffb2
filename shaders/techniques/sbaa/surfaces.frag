#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: WIDE=-DHALVES=0 NARROW=-DHALVES=1
// The G-buffer samples of the kept surfaces: a fragment whose first visible sample is a kept surface's first is stored.
// Reads: visibility, surfaces.
// Writes: to the surface's layer, a sample as in stored_sample.glsl, NARROW: in halves of words. One fragment at most writes a
// texel, so they need no order.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "deferred/stored_sample.glsl"
#include "include/visibility.glsl"
#include "techniques/sbaa/sbaa_interface.h"
#include "techniques/sbaa/surface_words.glsl"

layout(constant_id = SBAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
layout(set = 0, binding = SAMPLED(SBAA_SLOT_SURFACES)) uniform usampler2D surfaces;
#if HALVES
layout(set = 0, binding = STORAGE_IMAGE(SBAA_SLOT_STORED), rgba16ui) writeonly uniform uimage2DArray out_surfaces;
#else
layout(set = 0, binding = STORAGE_IMAGE(SBAA_SLOT_STORED), rgba32ui) writeonly uniform uimage2DArray out_surfaces;
#endif

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uvec4 own = uvec4(fragment_triangle());
  uint shown = 0u;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    bvec4 same = equal(visible_triangles(pixel, SAMPLES, quad), own);
    uvec4 bits = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), same);
    shown |= (bits.x | bits.y | bits.z | bits.w) << 4u * quad;
  }
  uint layer = SURFACES;
  for (bool go = shown != 0u; go; go = false) {
    uvec4 texel = texelFetch(surfaces, pixel, 0);
    uint first = uint(findLSB(shown));
    for (uint k = 0u; k < SURFACES; ++k) {
      uint word = stored_surface(texel, k);
      layer = word != 0u && surface_first(word) == first ? k : layer;
    }
  }
  for (bool go = layer < SURFACES; go; go = false) {
    uvec4 stored = stored_sample(fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES)));
#if HALVES
    stored = halves_of_words(stored);
#endif
    imageStore(out_surfaces, ivec3(pixel, layer), stored);
  }
}
