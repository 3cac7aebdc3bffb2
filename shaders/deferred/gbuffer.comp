#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: WIDE=-DTEXEL=rgba32ui NARROW=-DTEXEL=rgba16ui
// Full G-buffer samples: each fragment that shows writes its surface to those of GROUP_SAMPLES samples that show it.
// Reads: listed fragments, records, the source triangles' vertices, materials.
// Writes: a layer for each sample, as in stored_sample.glsl; those of samples that show the sky stay as they are.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "deferred/deferred_interface.h"
#include "deferred/stored_sample.glsl"

layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;  // which GROUP_SAMPLES samples of the pattern
layout(constant_id = CONSTANT_GROUP_SAMPLES) const uint GROUP_SAMPLES = 8u;
layout(constant_id = DEFERRED_CONSTANT_FIRST_LAYER) const uint FIRST_LAYER = 0u;
layout(set = 0, binding = STORAGE_IMAGE(DEFERRED_SLOT_SAMPLES), TEXEL) writeonly uniform uimage2DArray out_samples;

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  const uint first = SAMPLE_GROUP * GROUP_SAMPLES;
  uint shown = bitfieldExtract(first < 32u ? fragment.z : fragment.w, int(first & 31u), int(GROUP_SAMPLES));
  // A loop, so that groups of fragments that show in none of these samples skip the attributes.
  for (bool go = shown != 0u; go; go = false) {
    load_fragment(fragment.x);
    ivec2 pixel = listed_pixel(fragment);
    uvec4 stored = stored_sample(fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES)));
    for (uint i = 0u; i < GROUP_SAMPLES; ++i)
      if ((shown >> i & 1u) != 0u) imageStore(out_samples, ivec3(pixel, FIRST_LAYER + i), stored);
  }
}
