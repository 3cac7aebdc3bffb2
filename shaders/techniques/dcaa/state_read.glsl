// A pixel's state, read back after the merge pass.
// Reads: as ordered_state_read.glsl. Needs surface.glsl and state.glsl before it.
#ifndef SUBPIXEL_DCAA_STATE_READ_GLSL
#define SUBPIXEL_DCAA_STATE_READ_GLSL

#include "include/ordered_state_read.glsl"
#include "include/ordered_state_words.glsl"

uint read_count_word(ivec2 pixel) { return state_quad(pixel, 0u).x; }

void read_surfaces(ivec2 pixel, out DcaaSurface surface[DCAA_MAX_SURFACES]) {
  DcaaState state;
  for (uint i = 0u; i < STATE_QUADS; ++i) SET_QUAD_OF(state.word, i, state_quad(pixel, i))
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);
}

#endif
