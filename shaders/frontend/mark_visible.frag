#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Flags the triangles that own a sample, so that attribute passes draw no others.
// Reads: visibility. Writes: one word for each record, 1 where it is visible.
#include "frontend/frontend_interface.h"
#include "include/visibility.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_VISIBLE), scalar) writeonly buffer Visible { uint visible[]; };

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  if (SAMPLES == 1u) {
    uint triangle = visible_sample(pixel).y;
    if (triangle != SUBPIXEL_NO_TRIANGLE) visible[triangle] = 1u;
    return;
  }
  // Neighbouring samples mostly see the same triangle: one store for each run of them, skipped where no lane has one.
  uint last = SUBPIXEL_NO_TRIANGLE;
  for (uint quad = 0u; quad < (SAMPLES + 3u) / 4u; ++quad) {
    uvec4 triangles = visible_triangles(pixel, SAMPLES, quad);
    for (uint i = 0u; i < 4u; ++i) {
      uint triangle = triangles[i];
      for (bool fresh = triangle != last && triangle != SUBPIXEL_NO_TRIANGLE; fresh; fresh = false) visible[triangle] = 1u;
      last = triangle;
    }
  }
}
