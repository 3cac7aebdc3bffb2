// The list part of a pixel's state, read back after the compression pass.
// Reads: as ordered_state_read.glsl. Needs compress.glsl and state.glsl before it.
#ifndef SUBPIXEL_STREAMING_STATE_READ_GLSL
#define SUBPIXEL_STREAMING_STATE_READ_GLSL

#include "include/ordered_state_read.glsl"

uint read_count_word(ivec2 pixel) { return state_quad(pixel, DEPTH_QUADS).x; }

void read_surfaces(ivec2 pixel, out StreamSurface surface[STREAM_MAX_SURFACES]) {
  StreamList list;
  for (uint i = 0u; i < LIST_QUADS; ++i) SET_QUAD_OF(list.word, i, state_quad(pixel, DEPTH_QUADS + i))
  uint word;
  stream_unpack(list, word, surface);
}

#endif
