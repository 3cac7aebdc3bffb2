// Blocks and pointers of the per-pixel lists: where their words are, and what a pointer says.
// Blocks 0 to width * height - 1 are the pixels' own, dynamic ones follow (Fridvalszky and Toth 2020, figure 4).
// Needs SAMPLES before it. Reads and writes: the pool's words, by address; a pass that only reads defines LINK_READS.
#ifndef SUBPIXEL_LINKED_LIST_BLOCKS_GLSL
#define SUBPIXEL_LINKED_LIST_BLOCKS_GLSL

#include "include/frame.glsl"
#include "include/visibility.glsl"
#include "techniques/linked_list/linked_list_interface.h"

#ifdef LINK_READS
#define LINK_ACCESS readonly
#else
#define LINK_ACCESS
#endif
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LinkWords { uint word[]; };
layout(constant_id = LINK_CONSTANT_ALLOCATION) const uint ALLOCATION = LINK_ALLOCATE_LARGEST;
layout(constant_id = LINK_CONSTANT_FIRST_BLOCK) const uint FIRST_BLOCK = LINK_FIRST_SAMPLE;
layout(constant_id = LINK_CONSTANT_LIGHTING) const uint LIGHTING = LINK_LIGHT_BLOCKS;

layout(set = 0, binding = STORAGE(LINK_SLOT_POOL), scalar) LINK_ACCESS buffer Pool { LinkPool pool; };

const uint kNoBlock = 0xffffffffu;
// 1 where a pair has its shared word: where one byte beside albedo and normal is too little (one_byte_more() of stored_sample.glsl).
const uint kShared = (FEATURES / FEATURE_METAL) & (FEATURES / FEATURE_VARYING_ROUGHNESS) & 1u;
const uint kPointers = 4u + kShared;
const uint kPairWords = kPointers + 2u + 2u * ((FEATURES / FEATURE_EMISSIVE) & 1u);

// Fields of a block that have a word of their own: 0 albedo and metallic or roughness, 1 normal; the pair's shared word is its fifth.
uint block_word(uint block, uint field) { return (block >> 1) * kPairWords + 2u * field + (block & 1u); }
uint shared_word(uint block) { return (block >> 1) * kPairWords + 4u; }
uint pointer_word(uint block) { return (block >> 1) * kPairWords + kPointers + (block & 1u); }
uint emission_word(uint block) { return (block >> 1) * kPairWords + kPointers + 2u + (block & 1u); }

uint make_link(uint block, uint count, uint s) {
  return block | (count - 1u) << LINK_COUNT_SHIFT | s << LINK_SAMPLE_SHIFT;
}
uint link_block(uint link) { return link & ((1u << LINK_INDEX_BITS) - 1u); }
uint link_count(uint link) { return ((link >> LINK_COUNT_SHIFT) & 7u) + 1u; }
uint link_sample(uint link) { return link >> LINK_SAMPLE_SHIFT; }

// A link and the pixel it leads from, without the block.
uint make_owner(ivec2 pixel, uint link) {
  return uint(pixel.x) | uint(pixel.y) << LINK_OWNER_SIDE_BITS | (link >> LINK_INDEX_BITS) << (2 * LINK_OWNER_SIDE_BITS);
}
ivec2 owner_pixel(uint owner) {
  return ivec2(owner, owner >> LINK_OWNER_SIDE_BITS) & ((1 << LINK_OWNER_SIDE_BITS) - 1);
}
uint owner_sample(uint owner) { return owner >> 29; }

uint pixel_block(ivec2 pixel) { return uint(pixel.y) * pool.width + uint(pixel.x); }
uint first_dynamic() { return pool.width * pool.height; }

// Devices run fragment shaders for whole blocks of pixels and may load for those outside the image: their pointers are no
// pointers and must not be followed.
bool in_image(ivec2 pixel) { return uint(pixel.x) < pool.width && uint(pixel.y) < pool.height; }

// Samples of the pixel that `triangle` shows in.
uint samples_of(ivec2 pixel, uint triangle) { return samples_showing(pixel, SAMPLES, triangle).x; }

uint covered_samples(ivec2 pixel) { return ~samples_of(pixel, SUBPIXEL_NO_TRIANGLE) & ((1u << SAMPLES) - 1u); }

// The sample whose surface the pixel's own block holds; none of the pixel's when that sample is not covered.
uint first_sample(uint covered) { return FIRST_BLOCK == LINK_FIRST_COVERED && covered != 0u ? uint(findLSB(covered)) : 0u; }

#endif
