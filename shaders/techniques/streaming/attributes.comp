#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The surfaces of the fragments that passed the depth test.
// Reads: listed fragments, materials. Writes: surfaces.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/fragment.glsl"
#include "techniques/streaming/listed.glsl"

layout(set = 0, binding = STORAGE(ORDERED_SLOT_SURFACES), scalar) readonly buffer SurfacesAddress {
  ListedSurfaces surfaces;
};

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  for (bool go = fragment.w != 0u; go; go = false) {
    load_fragment(fragment.x);
    ivec2 pixel = listed_pixel(fragment);
    PixelEdges edges = fragment_edges(pixel);
    uint geometry = fragment.z;
    if (has_feature(FEATURE_ALPHA_TEST)) {
      bool tested = (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
      for (bool again = tested; again; again = false) geometry = coverage_mask(edges, SAMPLES, 0u, SAMPLES);
    }
    StreamSurface s = stream_fragment(pixel, edges, fragment_depth(pixel), geometry);
    StreamListedSurface surface;
    surface.words = uvec4(floatBitsToUint(s.depth), s.slopes, s.albedo, s.normal);
    surface.more = uvec2(s.roughness, s.emission);
    surfaces.surface[number] = surface;
  }
}
