#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Empties all lists before the counter gives out blocks; one invocation for each pixel.
// Writes: the pixels' pointers; no block asked for.
layout(local_size_x = 64) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/linked_list/blocks.glsl"

void main() {
  // Rows of workgroups go over rows of pixels, since a dispatch has few of them in one dimension.
  uint x = gl_GlobalInvocationID.x;
  if (x >= pool.width) return;
  pool.words.word[pointer_word(gl_WorkGroupID.y * pool.width + x)] = 0u;
  if (x + gl_WorkGroupID.y == 0u) pool.allocated = 0u;
}
