// The G-buffer of per-pixel lists. Included by host and shaders.
// Fridvalszky and Toth 2020, "Multisample anti-aliasing in deferred rendering", figures 3 and 4.
#ifndef SUBPIXEL_LINKED_LIST_TYPES_H
#define SUBPIXEL_LINKED_LIST_TYPES_H

#ifdef __cplusplus
#include <cstdint>
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

// Specialization constant 10.
#define LINK_ALLOCATE_LARGEST 0u  // fragments with most samples first, of equal ones tile by tile
#define LINK_ALLOCATE_TILES 1u    // tile by tile
#define LINK_ALLOCATE_ATOMIC 2u   // as fragments come: the publication's counter
// Specialization constant 11.
#define LINK_FIRST_SAMPLE 0u   // the pre-allocated block is that of sample 0, empty when sample 0 shows the sky
#define LINK_FIRST_COVERED 1u  // ... of the first covered sample

// Specialization constant 12.
#define LINK_LIGHT_BLOCKS 0u  // dynamic blocks one by one, then pixels
#define LINK_LIGHT_LISTS 1u   // pixels, each its list
#define LINK_OWNER_BITS 32
#define LINK_OWNER_SIDE_BITS 13

// Pixels along the side of the tiles that allocation counts by.
#define LINK_TILE 8u

// Storage buffer: where the blocks are.
struct LinkPool {
#ifdef __cplusplus
  std::uint64_t words, owners;
  std::uint32_t
#else
  LinkWords words;   // of the blocks
  LinkWords owners;  // of each dynamic block: pixel x, y in 13 bits, samples less one, sample; with lighting by blocks
  uint
#endif
      capacity,   // dynamic blocks
      allocated,  // dynamic blocks that were asked for; may be more
      width, height;  // pixels
};

#ifdef __cplusplus
static_assert(sizeof(LinkPool) == 32);
}  // namespace subpixel::gpu_types
#endif
#endif
