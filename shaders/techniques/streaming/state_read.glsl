// The list part of a pixel's state, read back after the compression pass; with TILED as the ordered pass leaves it.
// Reads: as ordered_state_read.glsl. Needs compress.glsl and state.glsl before it.
#ifndef SUBPIXEL_STREAMING_STATE_READ_GLSL
#define SUBPIXEL_STREAMING_STATE_READ_GLSL

#ifdef TILED
#define STATE_QUADS STREAM_HEAD_QUADS(SAMPLES)
#define ENTRIES SURFACES
#define ENTRY_WORDS SURFACE_WORDS
#define ENTRIES_READ
#include "include/ordered_entries.glsl"
#else
#define STATE_QUADS LISTED_STATE_QUADS
#endif
#include "include/ordered_state_read.glsl"

uint read_count_word(ivec2 pixel) { return state_quad(pixel, DEPTH_QUADS).x; }

void read_surfaces(ivec2 pixel, out StreamSurface surface[STREAM_MAX_SURFACES]) {
  StreamList list;
#ifdef TILED
  for (uint i = 0u; i < MAX_LIST_WORDS; ++i) list.word[i] = 0u;
  list.word[0] = read_count_word(pixel);
  for (uint s = 0u; s < SURFACES; ++s)
    for (bool there = s < field_of(list.word[0], 0u, STREAM_COUNT_BITS); there; there = false)
      for (uint w = 0u; w < SURFACE_WORDS; ++w)
        list.word[1u + s * SURFACE_WORDS + w] = entries.words[entry_word(pixel, s, w)];
#else
  for (uint i = 0u; i < LIST_QUADS; ++i) SET_QUAD_OF(list.word, i, state_quad(pixel, DEPTH_QUADS + i))
#endif
  uint word;
  stream_unpack(list, word, surface);
}

#endif
