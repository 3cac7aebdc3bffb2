// A pixel's list as the passes after the geometry read it.
// Reads: visibility, pointers. Needs SAMPLES before it.
#ifndef SUBPIXEL_LINKED_LIST_LIST_GLSL
#define SUBPIXEL_LINKED_LIST_LIST_GLSL

#include "techniques/linked_list/blocks.glsl"

// The blocks with a surface by one sample each shows in. That puts the list in one order however it was linked.
struct PixelList {
  uint covered;                      // samples
  uint leaders;                      // samples that stand for a block
  uint listed;                       // samples of dynamic blocks
  uint own;                          // the sample of the pixel's own block
  uint link[LINK_MAX_SAMPLES];       // the pointer to each leader's block; the own block's has 0
};

PixelList read_list(LinkWords words, ivec2 pixel) {
  PixelList list;
  list.covered = in_image(pixel) ? covered_samples(pixel) : 0u;
  list.own = first_sample(list.covered);
  list.leaders = list.covered & (1u << list.own);
  list.listed = 0u;
  for (uint s = 0u; s < SAMPLES; ++s) list.link[s] = 0u;
  for (bool any_surface = list.covered != 0u; any_surface; any_surface = false) {
    for (uint link = words.word[pointer_word(pixel_block(pixel))]; link != 0u;
         link = words.word[pointer_word(link_block(link))]) {
      uint place = link_sample(link);
      for (uint s = 0u; s < SAMPLES; ++s) list.link[s] = place == s ? link : list.link[s];
      list.leaders |= 1u << place;
      list.listed += link_count(link);
    }
  }
  return list;
}

// Samples that show the pixel's own block: those of its fragment and those of fragments without a block.
uint own_samples(PixelList list) {
  return (list.covered & (1u << list.own)) != 0u ? uint(bitCount(list.covered)) - list.listed : 0u;
}

#endif
