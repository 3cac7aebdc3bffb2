#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#ifdef INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
#endif
// variants: 3=-DATTACHMENTS=3 5=-DATTACHMENTS=5 BUFFER=-DATTACHMENTS=0 INTERLOCK=-DATTACHMENTS=0,-DINTERLOCK
// The compression pass: a fragment that passes the n-sample depth test in some sample goes into its pixel's surfaces.
// Reads and writes, in primitive order: the pixel's depths and count word; of its surfaces those that there are and those that
// change (section 4 of the paper).
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#define STATE_QUADS STREAM_HEAD_QUADS(SAMPLES)
#include "include/ordered_state.glsl"
#define ENTRIES SURFACES
#define ENTRY_WORDS SURFACE_WORDS
#include "include/ordered_entries.glsl"
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
      for (uint i = 0u; i < MAX_LIST_WORDS; ++i) list.word[i] = 0u;
      uvec4 head = quad(DEPTH_QUADS);
      list.word[0] = head.x;
      uint before = field_of(head.x, 0u, STREAM_COUNT_BITS);
      for (uint s = 0u; s < SURFACES; ++s)
        for (bool there = s < before; there; there = false)
          for (uint w = 0u; w < SURFACE_WORDS; ++w)
            list.word[1u + s * SURFACE_WORDS + w] = entries.words[entry_word(pixel, s, w)];
      uint word;
      StreamSurface surface[STREAM_MAX_SURFACES];
      stream_unpack(list, word, surface);

      StreamSurface fragment = stream_fragment(pixel, edges, plane, geometry);
      fragment.coverage = mask;
      fragment.resolved = stream_option(STREAM_DEPTH_TESTED) ? passed : mask;
      stream_add(word, surface, fragment);

      StreamList changed;
      stream_pack(word, surface, changed);
      for (uint i = 0u; i < DEPTH_QUADS; ++i) set_quad(i, depths[i]);
      uint after = field_of(word, 0u, STREAM_COUNT_BITS), stored = 0u;
      for (uint s = 0u; s < SURFACES; ++s) {
        bool differs = s >= before;
        for (uint w = 1u + s * SURFACE_WORDS; w < 1u + (s + 1u) * SURFACE_WORDS; ++w)
          differs = differs || changed.word[w] != list.word[w];
        differs = differs && s < after;
        stored += differs ? SURFACE_WORDS : 0u;
        for (bool put = differs; put; put = false)
          for (uint w = 0u; w < SURFACE_WORDS; ++w)
            entries.words[entry_word(pixel, s, w)] = changed.word[1u + s * SURFACE_WORDS + w];
      }
      for (uint i = DEPTH_QUADS + 1u; i < ATTACHMENTS; ++i) set_quad(i, uvec4(0u));  // one more than needed, with 4 samples
      set_quad(DEPTH_QUADS, uvec4(word, head.y + before * SURFACE_WORDS, head.z + stored, 0u));
    }
  }
  end_ordered();
  if (passed == 0u) discard;
}
