#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The surfaces of kept fragments.
// Reads: listed fragments, the camera, materials. Writes: surfaces.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#define LISTED
#include "techniques/dcaa/fragment_mask.glsl"
#include "frontend/listed_fragment.glsl"
#include "techniques/dcaa/fragment.glsl"
#include "techniques/dcaa/listed.glsl"

layout(set = 0, binding = STORAGE(DCAA_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(set = 0, binding = STORAGE(ORDERED_SLOT_SURFACES), scalar) readonly buffer SurfacesAddress {
  ListedSurfaces surfaces;
};

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  for (bool go = (fragment.x & kKept) != 0u && fragment.x != kNothing; go; go = false) {
    load_fragment(fragment.x & ~kKept);
    ivec2 pixel = listed_pixel(fragment);
    PixelEdges edges = fragment_edges(pixel);
    uvec2 geometry = fragment.zw;
    if (has_feature(FEATURE_ALPHA_TEST)) {
      bool tested = (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
      for (bool again = tested; again; again = false) geometry = fragment_coverage(edges);
    }
    vec2 offset = mask_shading_offset(edges, geometry);
    DcaaView camera = view;
    DcaaSurface s = dcaa_fragment(pixel, fragment_depth(pixel), offset, dcaa_ray(pixel, camera), camera);
    DcaaListedSurface surface;
    surface.words = uvec4(s.facet.x, floatBitsToUint(s.depth), s.albedo, s.normal);
    surface.more = uvec4(s.roughness, s.emission, s.facet.yz);
    surfaces.surface[number] = surface;
  }
}
