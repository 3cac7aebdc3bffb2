#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#ifdef INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
#endif
// variants: 3=-DATTACHMENTS=3 4=-DATTACHMENTS=4 5=-DATTACHMENTS=5 6=-DATTACHMENTS=6 7=-DATTACHMENTS=7 8=-DATTACHMENTS=8 BUFFER=-DATTACHMENTS=0 INTERLOCK=-DATTACHMENTS=0,-DINTERLOCK
// The merge pass: every fragment that the prepass does not rule out goes into its pixel's surfaces.
// Reads: the prepass's bound, the camera, materials. Reads and writes: the pixel's state
// (state.glsl), in primitive order.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "techniques/dcaa/fragment_mask.glsl"
#include "techniques/dcaa/depth_bound.glsl"
#include "techniques/dcaa/fragment.glsl"
#include "techniques/dcaa/merge.glsl"
#include "techniques/dcaa/state.glsl"
#include "include/ordered_state.glsl"

layout(set = 0, binding = STORAGE(DCAA_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(set = 0, binding = SAMPLED(DCAA_SLOT_BOUND)) uniform usampler2DArray depth_bound;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  begin_ordered();
  DepthPlane plane = fragment_depth(pixel);
  vec3 bound = dcaa_option(DCAA_PREPASS) ? uintBitsToFloat(texelFetch(depth_bound, ivec3(pixel, 0), 0).xyz) : vec3(0.0);
  bool stored = false;
  for (bool seen = may_show(plane, bound); seen; seen = false) {
    PixelEdges edges = fragment_edges(pixel);
    uvec2 geometry = fragment_coverage(edges), mask = geometry;
    for (bool covered = geometry != uvec2(0u); covered; covered = false) {
      vec2 offset = mask_shading_offset(edges, geometry);
      if (has_feature(FEATURE_ALPHA_TEST)) {
        bool tested = (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
        for (bool go = tested; go; go = false) mask = alpha_coverage(geometry, pixel, offset);
      }
      for (bool go = mask != uvec2(0u); go; go = false) {
        find_state(pixel);
        DcaaState state;
        for (uint i = 0u; i < STATE_QUADS; ++i) SET_QUAD_OF(state.word, i, quad(i))
        DcaaSurface surface[DCAA_MAX_SURFACES];
        for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);

        DcaaView camera = view;
        vec3 ray = dcaa_ray(pixel, camera);
        DcaaSurface fragment = dcaa_fragment(pixel, plane, offset, ray, camera);
        fragment.coverage = mask;
        dcaa_add(state.word[0], surface, fragment, ray, camera);

        for (uint i = 0u; i < SURFACES; ++i) dcaa_pack(surface[i], i, state);
        for (uint i = 0u; i < STATE_QUADS; ++i) set_quad(i, QUAD_OF(state.word, i));
        stored = true;
      }
    }
  }
  end_ordered();
  if (!stored) discard;
}
