#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Each visible fragment writes its surface to one block.
// The fragment with the pixel's chosen sample writes the pixel's own block, any other a dynamic one: the one that link.comp
// gave it, or (ATOMIC) the next of a counter, which it puts before the pixel's list. Without a block left it writes nothing.
// Reads: listed fragments, visibility, pointers. Writes: surfaces of the blocks; ATOMIC: pointers, owners and the counter.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "deferred/stored_sample.glsl"
#include "techniques/linked_list/blocks.glsl"

// Both blocks of a pair share a word and are written by fragments of any order, each of which changes its own bytes.
void write_surface(LinkWords words, uint block, uvec4 packed) {
  uvec2 own = one_byte_more() ? narrowed(packed) : packed.xy;
  words.word[block_word(block, 0u)] = own.x;
  words.word[block_word(block, 1u)] = own.y;
  if (!one_byte_more()) {
    uint shift = 8u * (block & 1u);
    uint bytes = ((packed.z & 255u) | (packed.z & 0xff00u) << 8) << shift;
    atomicAnd(words.word[shared_word(block)], ~(0x00ff00ffu << shift));
    atomicOr(words.word[shared_word(block)], bytes);
  }
  if (has_feature(FEATURE_EMISSIVE)) words.word[emission_word(block)] = packed.w;
}

void main() {
  uint number;
  if (!listed_number(number)) return;
  uvec4 fragment = lists.fragments.fragment[number];
  ivec2 pixel = listed_pixel(fragment);
  uint mask = fragment.z;
  LinkWords words = pool.words;
  uint own = pixel_block(pixel), place = own, lowest = uint(findLSB(mask));
  uint first = FIRST_BLOCK == LINK_FIRST_COVERED ? first_sample(covered_samples(pixel)) : 0u;
  // Loops, here and below, so that groups of fragments skip what none of them needs.
  for (bool dynamic = (mask & (1u << first)) == 0u; dynamic; dynamic = false) {
    place = kNoBlock;
    if (ALLOCATION == LINK_ALLOCATE_ATOMIC) {
      uint next = atomicAdd(pool.allocated, 1u);
      for (bool fits = next < pool.capacity; fits; fits = false) {
        place = first_dynamic() + next;
        uint link = make_link(place, bitCount(mask), lowest);
        if (LIGHTING == LINK_LIGHT_BLOCKS) pool.owners.word[next] = make_owner(pixel, link);
        words.word[pointer_word(place)] = atomicExchange(words.word[pointer_word(own)], link);
      }
    } else {
      uint link = words.word[pointer_word(own)];
      while (link != 0u && link_sample(link) != lowest) link = words.word[pointer_word(link_block(link))];
      place = link == 0u ? kNoBlock : link_block(link);
    }
  }
  for (bool write = place != kNoBlock; write; write = false) {
    load_fragment(fragment.x);
    write_surface(words, place,
                  pack_surface(fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES))));
  }
}
