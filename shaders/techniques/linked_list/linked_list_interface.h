// The G-buffer of per-pixel lists. Included by host and shaders.
// Fridvalszky and Toth 2020, "Multisample anti-aliasing in deferred rendering", figures 3 and 4.
#ifndef SUBPIXEL_LINKED_LIST_INTERFACE_H
#define SUBPIXEL_LINKED_LIST_INTERFACE_H

#include "../../frontend/frontend_interface.h"

#define LINK_CONSTANT_ALLOCATION 7   // LINK_ALLOCATE_
#define LINK_CONSTANT_FIRST_BLOCK 8  // LINK_FIRST_
#define LINK_CONSTANT_LIGHTING 9     // LINK_LIGHT_

// Storage.
#define LINK_SLOT_POOL 1
#define LINK_SLOT_TILE_SUMS 2  // blocks that tiles need, level by level
#define LINK_SLOT_GROUPS 3     // of the indirect dispatch that lights the dynamic blocks
// Sampled.
#define LINK_SLOT_LEADERS 1

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// A pointer: the block's index in its low 26 bits, then the samples of that block less one, then the number of one of them.
// Index 0 is that of a pre-allocated block, to which nothing points: it ends a list.
#define LINK_INDEX_BITS 26
#define LINK_COUNT_SHIFT 26
#define LINK_SAMPLE_SHIFT 29
#define LINK_MAX_SAMPLES 8u

// Two blocks interleaved: albedo and metallic of each, normal of each, both roughnesses and occlusions in one word,
// pointer of each. Scenes with emission add a word for each, which the publication has none for; those without metal, or of one
// roughness, do without the shared word.
#define LINK_PAIR_WORDS 7u
#define LINK_BLOCK_BITS 112
#define LINK_POINTER_BITS 32

#define LINK_ALLOCATE_LARGEST 0u  // fragments with most samples first, of equal ones tile by tile
#define LINK_ALLOCATE_TILES 1u    // tile by tile
#define LINK_ALLOCATE_ATOMIC 2u   // as fragments come: the publication's counter
#define LINK_FIRST_SAMPLE 0u   // the pre-allocated block is that of sample 0, empty when sample 0 shows the sky
#define LINK_FIRST_COVERED 1u  // ... of the first covered sample

#define LINK_LIGHT_BLOCKS 0u  // dynamic blocks one by one, then pixels
#define LINK_LIGHT_LISTS 1u   // pixels, each its list
#define LINK_OWNER_BITS 32
#define LINK_OWNER_SIDE_BITS 13

// Pixels along the side of the tiles that allocation counts by.
#define LINK_TILE 8u

BUFFER_REFERENCE(LinkWords)

// Storage buffer: where the blocks are.
struct LinkPool {
  ADDRESS(LinkWords) words;   // of the blocks
  ADDRESS(LinkWords) owners;  // of each dynamic block: pixel x, y in 13 bits, samples less one, sample; with lighting by blocks
  uint capacity;              // dynamic blocks
  uint allocated;             // dynamic blocks that were asked for; may be more
  uint width;                 // pixels
  uint height;
};

#ifdef __cplusplus
static_assert(sizeof(LinkPool) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
