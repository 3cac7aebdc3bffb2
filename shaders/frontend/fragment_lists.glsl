// The fragments of a frame as lists: once by triangle, in submission order, and once by pixel.
// A fragment is (record, pixel x | y << 16, two words of masks or what a technique puts there).
// Reads: nothing; the buffers come with the including shader's push constants or by ListAddresses.
#ifndef SUBPIXEL_FRAGMENT_LISTS_GLSL
#define SUBPIXEL_FRAGMENT_LISTS_GLSL

#include "frontend/frontend_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Fragments { uvec4 fragment[]; };
// Numbers of the fragments of each pixel, pixel after pixel; within a pixel in submission order once they are sorted.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentNumbers { uint number[]; };
// Where each pixel's part of them ends; the next one's begins there. While fragments are stored: where its next one goes.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PixelEnds { uint end[]; };
// Of each triangle record: how many fragments it has; then the number of its first.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentBases { uint base[]; };

// The pixel of an invocation of a pass over pixels, dispatched as 64 invocations for 8x8 pixels. Eight neighbours, a vector on
// lavapipe, stand 4x2: their lists are of like length more often than in a row.
ivec2 invocation_pixel(uvec2 group, uint local) {
  uvec2 at = uvec2((local & 3u) + ((local >> 1) & 4u), ((local >> 2) & 1u) + ((local >> 3) & 6u));
  return ivec2(8u * group + at);
}

// [begin, end) of pixel p's part of the numbers.
uvec2 list_range(ListAddresses lists, uint p) {
  return uvec2(p == 0u ? 0u : lists.ends.end[p - 1u], lists.ends.end[p]);
}

// Lists come nearly sorted, which insertion likes; long ones may not take its worst case, since some drivers end loops after
// 65,535 turns, so they go through a heap. Those of several parts are sorted before, by sort_part.comp and merge_parts.comp.
const uint kLongInsertion = 96u;

void sort_by_insertion(FragmentNumbers numbers, uint begin, uint end) {
  for (uint i = begin + 1u; i < end; ++i) {
    uint own = numbers.number[i], place = i;
    while (place > begin) {
      uint before = numbers.number[place - 1u];
      if (before <= own) break;
      numbers.number[place] = before;
      --place;
    }
    if (place != i) numbers.number[place] = own;
  }
}

void sort_by_heap(FragmentNumbers numbers, uint begin, uint end) {
  uint size = end - begin, unplaced = size / 2u;
  while (size > 1u) {
    // First every inner node sinks to its place, then the largest goes behind the shrinking heap.
    bool building = unplaced > 0u;
    uint node = 0u, own;
    if (building) {
      --unplaced;
      node = unplaced;
      own = numbers.number[begin + node];
    } else {
      --size;
      own = numbers.number[begin + size];
      numbers.number[begin + size] = numbers.number[begin];
    }
    while (true) {
      uint child = 2u * node + 1u;
      if (child >= size) break;
      uint value = numbers.number[begin + child];
      uint second = child + 1u < size ? numbers.number[begin + child + 1u] : 0u;
      if (second > value) {
        ++child;
        value = second;
      }
      if (value <= own) break;
      numbers.number[begin + node] = value;
      node = child;
    }
    numbers.number[begin + node] = own;
  }
}

// Brings [begin, end) of the numbers into submission order.
void sort_list(FragmentNumbers numbers, uint begin, uint end) {
  for (bool go = end - begin <= kLongInsertion; go; go = false) sort_by_insertion(numbers, begin, end);
  for (bool go = end - begin > kLongInsertion && end - begin <= SUBPIXEL_LIST_PART; go; go = false)
    sort_by_heap(numbers, begin, end);
}

#endif
