// The triangle buffer: which triangle a fragment has, and attributes from a triangle's planes.
// Reads: the triangle buffer. Needs frame.glsl's FEATURES.
#ifndef SUBPIXEL_DAIS_TRIANGLES_GLSL
#define SUBPIXEL_DAIS_TRIANGLES_GLSL

#include "techniques/dais/dais_interface.h"

// Of fragment i: before the scan 1 if it is its triangle's first, then how many triangles come before that of i, or end at i.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TriangleNumbers { uint number[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TriangleWords { uint word[]; };
layout(set = 0, binding = STORAGE(DAIS_SLOT_TRIANGLES), scalar) readonly buffer Triangles { TriangleBuffer triangles; };

const uint kTriangleWords = DAIS_WORDS(FEATURES);

uint triangle_of(TriangleBuffer t, uint fragment) { return t.numbers.number[fragment + 1u] - 1u; }

// Is fragment `fragment` to be interpolated from planes? `first`: of its triangle's words.
bool has_planes(TriangleBuffer t, uint fragment, out uint first) {
  first = 0u;
  bool held = false;
  for (bool go = t.capacity > 0u; go; go = false) {
    uint triangle = triangle_of(t, fragment);
    held = triangle < t.capacity;
    first = held ? triangle * kTriangleWords : 0u;
    held = held && t.words.word[first] != DAIS_NO_PLANES;
  }
  return held;
}

#endif
