#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: WIDE=-DTEXEL=rgba32ui NARROW=-DTEXEL=rgba16ui
// The G-buffer samples of the kept surfaces: a fragment whose first visible sample is a kept surface's first is stored.
// Reads: listed fragments, surfaces; of what is stored, records, the source triangles' vertices, materials.
// Writes: to the surface's layer, a sample as in stored_sample.glsl. One fragment at most writes a texel, so they need no order.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "deferred/stored_sample.glsl"
#include "techniques/sbaa/sbaa_interface.h"
#include "techniques/sbaa/surface_words.glsl"

layout(constant_id = SBAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
layout(set = 0, binding = SAMPLED(SBAA_SLOT_SURFACES)) uniform usampler2D surfaces;
layout(set = 0, binding = STORAGE_IMAGE(SBAA_SLOT_STORED), TEXEL) writeonly uniform uimage2DArray out_surfaces;

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  ivec2 pixel = listed_pixel(fragment);
  uvec4 texel = texelFetch(surfaces, pixel, 0);
  uint layer = SURFACES, first = uint(findLSB(fragment.z));
  for (uint k = 0u; k < SURFACES; ++k) {
    uint word = stored_surface(texel, k);
    layer = word != 0u && surface_first(word) == first ? k : layer;
  }
  // A loop, so that groups of fragments that are not kept skip the attributes.
  for (bool go = layer < SURFACES; go; go = false) {
    load_fragment(fragment.x);
    imageStore(out_surfaces, ivec3(pixel, layer),
               stored_sample(fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES))));
  }
}
