// A pixel's list entries apart from the rest of its state, as section 4 of Kerzner and Salvi 2014 has them: in a buffer that nobody
// clears, since a count kept elsewhere says which entries there are, and tiled, so that entries of neighbouring pixels lie
// together: entry by entry of a tile, word by word of an entry, the words of the tile's pixels one after another.
// Define ENTRIES, entries of a pixel, and ENTRY_WORDS before it. Needs frame.glsl.
// Reads and, unless ENTRIES_READ is defined, writes: the buffer whose address ORDERED_SLOT_ENTRIES holds.
#ifndef SUBPIXEL_ORDERED_ENTRIES_GLSL
#define SUBPIXEL_ORDERED_ENTRIES_GLSL

#include "include/ordered_state.h"

#ifdef ENTRIES_READ
#define ENTRIES_ACCESS readonly
#elif defined(INTERLOCK)
#define ENTRIES_ACCESS coherent
#else
#define ENTRIES_ACCESS
#endif
layout(buffer_reference, scalar, buffer_reference_align = 4) ENTRIES_ACCESS buffer EntryWords { uint words[]; };
layout(set = 0, binding = STORAGE(ORDERED_SLOT_ENTRIES), scalar) readonly buffer EntriesAddress { EntryWords entries; };

uint entry_word(ivec2 pixel, uint entry, uint word) {
  uvec2 p = uvec2(pixel), tile = p / ORDERED_TILE, place = p % ORDERED_TILE;
  uint tiles_x = (uint(frame.viewport.x) + ORDERED_TILE - 1u) / ORDERED_TILE;
  uint first = (tile.y * tiles_x + tile.x) * (ENTRIES * ENTRY_WORDS);
  return (first + entry * ENTRY_WORDS + word) * (ORDERED_TILE * ORDERED_TILE) + place.y * ORDERED_TILE + place.x;
}

#endif
