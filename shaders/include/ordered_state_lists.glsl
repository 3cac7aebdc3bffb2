// What the passes over fragment lists that fill a state write.
// Needs fragment_lists.glsl before it. Reads: nothing; the addresses are those of OrderedKeepPush and OrderedMergePush.
#ifndef SUBPIXEL_ORDERED_STATE_LISTS_GLSL
#define SUBPIXEL_ORDERED_STATE_LISTS_GLSL

#include "include/ordered_state.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer StateQuads { uvec4 quads[]; };
// How many fragments of each pixel are kept; their numbers stand first in its part of the list.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer KeptCounts { uint count[]; };

// [begin, end) of the fragments that a merging pass takes of a pixel, whose kept ones are [first, first + kept).
uvec2 merged_part(uint first, uint kept, uint part) {
  uint begin = min(part * SUBPIXEL_LIST_PART, kept);
  return first + uvec2(begin, min(begin + SUBPIXEL_LIST_PART, kept));
}

#endif
