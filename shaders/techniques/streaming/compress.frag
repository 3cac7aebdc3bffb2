#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#ifdef INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
#endif
// variants: 3=-DATTACHMENTS=3 4=-DATTACHMENTS=4 5=-DATTACHMENTS=5 6=-DATTACHMENTS=6 7=-DATTACHMENTS=7 8=-DATTACHMENTS=8 BUFFER=-DATTACHMENTS=0 INTERLOCK=-DATTACHMENTS=0,-DINTERLOCK
// The compression pass: a fragment that passes the n-sample depth test in some sample goes into its pixel's surfaces.
// Reads and writes: the pixel's state (state.glsl), in primitive order.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "include/ordered_state.glsl"
#include "techniques/streaming/fragment.glsl"

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  begin_ordered();
  PixelEdges edges = fragment_edges(pixel);
  uint geometry = coverage_mask(edges, SAMPLES, 0u, SAMPLES);
  uint mask = geometry;
  if (has_feature(FEATURE_ALPHA_TEST)) {
    bool tested = (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
    // Textures are read only where the fragment may be nearest so far.
    for (bool go = tested && geometry != 0u; go; go = false) {
      find_state(pixel);
      DepthPlane plane = fragment_depth(pixel);
      uint nearest = 0u;
      for (uint i = 0u; i < DEPTH_QUADS; ++i) {
        uvec4 before = quad(i);
        nearest |= stream_passed(before, stream_nearer(before, SAMPLES, geometry, 4u * i, plane), 4u * i);
      }
      mask = 0u;
      for (bool again = nearest != 0u; again; again = false)
        mask = alpha_mask(geometry, 0u, SAMPLES, pixel, mask_offset(edges, geometry));
    }
  }

  uint passed = 0u;
  // Loops, here and below, are skipped when no lane needs them: fragments without a sample cost no read, rejected ones neither
  // attributes nor the list.
  for (bool covered = mask != 0u; covered; covered = false) {
    find_state(pixel);
    DepthPlane plane = fragment_depth(pixel);
    uvec4 depths[8];
    for (uint i = 0u; i < DEPTH_QUADS; ++i) {
      uvec4 before = quad(i);
      depths[i] = stream_nearer(before, SAMPLES, mask, 4u * i, plane);
      passed |= stream_passed(before, depths[i], 4u * i);
    }
    for (bool go = passed != 0u; go; go = false) {
      StreamList list;
      for (uint i = 0u; i < LIST_QUADS; ++i) SET_QUAD_OF(list.word, i, quad(DEPTH_QUADS + i))
      uint word;
      StreamSurface surface[STREAM_MAX_SURFACES];
      stream_unpack(list, word, surface);

      StreamSurface fragment = stream_fragment(pixel, edges, plane, geometry);
      fragment.coverage = mask;
      fragment.resolved = stream_option(STREAM_DEPTH_TESTED) ? passed : mask;
      stream_add(word, surface, fragment);

      stream_pack(word, surface, list);
      for (uint i = 0u; i < DEPTH_QUADS; ++i) set_quad(i, depths[i]);
      for (uint i = 0u; i < LIST_QUADS; ++i) set_quad(DEPTH_QUADS + i, QUAD_OF(list.word, i));
    }
  }
  end_ordered();
  if (passed == 0u) discard;
}
