// Words of a pixel's state: their quads, and what counts in them.
// Reads: its arguments.
#ifndef SUBPIXEL_ORDERED_STATE_WORDS_GLSL
#define SUBPIXEL_ORDERED_STATE_WORDS_GLSL

#include "include/ordered_state.h"

// Quad i of an array of words, and back. Loops over them have to be unrolled, or the array lies in memory.
#define QUAD_OF(word, i) uvec4(word[4u * (i)], word[4u * (i) + 1u], word[4u * (i) + 2u], word[4u * (i) + 3u])
#define SET_QUAD_OF(word, i, value)                                \
  {                                                                \
    uvec4 four = value;                                            \
    for (uint c = 0u; c < 4u; ++c) word[4u * (i) + c] = four[c]; \
  }

uint field_of(uint word, uint shift, uint bits) { return (word >> shift) & ((1u << bits) - 1u); }

// The word with `more` added to the field, which stops at its largest value.
uint count_more(uint word, uint shift, uint bits, uint more) {
  uint most = (1u << bits) - 1u;
  uint value = min(field_of(word, shift, bits) + more, most);
  return (word & ~(most << shift)) | value << shift;
}

#endif
