#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Lights the dynamic blocks, one invocation each, so that no lane waits for a longer list.
// Reads: owners, visibility, blocks, shadow map. Writes: lit values in the place of albedo and normal.
layout(local_size_x = 64) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "deferred/pixel_list.glsl"
#include "techniques/linked_list/blocks.glsl"
#include "techniques/linked_list/read_surface.glsl"

void main() {
  uint place = pixel_list_place(gl_WorkGroupID, gl_LocalInvocationID.x);
  if (place >= min(pool.allocated, pool.capacity)) return;
  LinkWords words = pool.words;
  uint owner = pool.owners.word[place], block = first_dynamic() + place;
  uvec2 lit = pack_lit(lit_block(words, block, owner_pixel(owner), owner_sample(owner)));
  words.word[block_word(block, 0u)] = lit.x;
  words.word[block_word(block, 1u)] = lit.y;
}
