// The fragments of a frame as lists: once by triangle, in submission order, and once by pixel.
// A fragment is (record, pixel x | y << 16, mask of samples 0-31, and of 32-63 or what a technique puts there).
// Reads: nothing; the buffers come with the including shader's push constants or by ListAddresses.
#ifndef SUBPIXEL_FRAGMENT_LISTS_GLSL
#define SUBPIXEL_FRAGMENT_LISTS_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Fragments { uvec4 fragment[]; };
// Numbers of the fragments of each pixel, pixel after pixel; within a pixel in submission order once they are sorted.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentNumbers { uint number[]; };
// Where each pixel's part of them ends; the next one's begins there. While fragments are stored: where its next one goes.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PixelEnds { uint end[]; };
// Of each triangle record: how many fragments it has; then the number of its first.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentBases { uint base[]; };

struct ListAddresses {
  Fragments fragments;
  FragmentNumbers numbers;
  PixelEnds ends;
  FragmentBases bases;
};

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

#endif
