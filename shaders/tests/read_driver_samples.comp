#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Copies the four samples of each pixel of a multisampled image into a buffer that tests read.
// Reads: the image. Writes: four words for each pixel, rows from the top.
layout(local_size_x = 64) in;
#include "tests/test_interface.h"

layout(set = 0, binding = SAMPLED(TEST_SLOT_IMAGE)) uniform usampler2DMS image;
layout(set = 0, binding = STORAGE(TEST_SLOT_SAMPLES), scalar) writeonly buffer Samples { uint samples[]; };
void main() {
  uvec2 size = uvec2(textureSize(image));
  uint place = gl_GlobalInvocationID.x;
  if (place >= size.x * size.y) return;
  ivec2 pixel = ivec2(place % size.x, place / size.x);
  for (int s = 0; s < 4; ++s) samples[4u * place + uint(s)] = texelFetch(image, pixel, s).x;
}
