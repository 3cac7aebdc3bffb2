#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Copies the visibility image into a buffer that tests read: (depth bits, triangle) of every sample.
// Reads: the visibility image. Writes: SAMPLES entries for each pixel, rows from the top.
layout(local_size_x = 64) in;
#include "include/visibility.glsl"
#include "tests/test_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = STORAGE(TEST_SLOT_SAMPLES), scalar) writeonly buffer Samples { uvec2 samples[]; };

void main() {
  uvec2 size = uvec2(textureSize(visibility, 0).xy);
  uint place = gl_GlobalInvocationID.x;
  if (place >= size.x * size.y) return;
  ivec2 pixel = ivec2(place % size.x, place / size.x);
  if (SAMPLES == 1u) {
    samples[place] = visible_sample(pixel);
    return;
  }
  for (uint quad = 0u; quad < (SAMPLES + 3u) / 4u; ++quad) {
    uvec4 depths = visible_depths(pixel, SAMPLES, quad), triangles = visible_triangles(pixel, SAMPLES, quad);
    for (uint i = 0u; i < min(4u, SAMPLES); ++i) samples[place * SAMPLES + 4u * quad + i] = uvec2(depths[i], triangles[i]);
  }
}
