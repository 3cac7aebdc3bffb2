#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Tells of the blocks of one pixel, its own first, then its list from the start; before blocks are lit, which takes the
// place of their attributes.
// Reads: visibility, blocks, which pixel. Writes: the blocks.
layout(local_size_x = 1) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "techniques/linked_list/list.glsl"
#include "techniques/linked_list/read_surface.glsl"
#include "techniques/linked_list/story_interface.h"

layout(set = 0, binding = STORAGE(LINK_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, blocks
  LinkStoredBlock block_at[];
};

void tell_block(LinkWords words, uint block, uint count, uint s, uint link) {
  block_at[told.z].of = uvec4(block, count, s, link);
  block_at[told.z].surface = packed_surface(words, block);
  told.z = told.z + 1u;
}

void main() {
  ivec2 pixel = ivec2(told.xy);
  LinkWords words = pool.words;
  PixelList list = read_list(words, pixel);
  if ((list.covered & (1u << list.own)) != 0u)
    tell_block(words, pixel_block(pixel), own_samples(list), list.own, 0u);
  if (list.covered == 0u) return;
  for (uint link = words.word[pointer_word(pixel_block(pixel))]; link != 0u;
       link = words.word[pointer_word(link_block(link))])
    tell_block(words, link_block(link), link_count(link), link_sample(link), link);
}
