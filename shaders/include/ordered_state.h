// Where techniques whose pixels merge fragments in submission order keep what they know of a pixel, and the passes over
// fragment lists that fill it: 32-bit words, four of them a quad, in colour attachments or in a buffer.
#ifndef SUBPIXEL_ORDERED_STATE_H
#define SUBPIXEL_ORDERED_STATE_H

#include "../frontend/frontend_interface.h"
#include "interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Attachments of one ordered pass. Vulkan requires 4; devices that run us have 8.
#define ORDERED_FEWEST_ATTACHMENTS 3
#define ORDERED_MOST_ATTACHMENTS 8

// Of passes that read the state, and of those that write it in a buffer.
#define ORDERED_SLOT_ADDRESS 0      // storage: where its quads are, pixel after pixel, row by row
#define ORDERED_SLOT_ATTACHMENTS 0  // sampled: the attachments, a layer each
// Of passes that make the listed fragments' surfaces.
#define ORDERED_SLOT_SURFACES 3  // storage: where they are

#define ORDERED_SLOT_ENTRIES 1  // storage: where the pixels' entries are, with ordered_entries.glsl

#define ORDERED_QUADS_OF(words) (((words) + 3u) / 4u)
// Pixels of a square tile's side whose entries lie together.
#define ORDERED_TILE 8

BUFFER_REFERENCE(StateQuads)
BUFFER_REFERENCE(KeptCounts)
BUFFER_REFERENCE(ListedSurfaces)  // of listed fragments, as a technique needs them

// Of passes over pixels that sort their lists and keep some of the fragments.
struct OrderedKeepPush {
  ListAddresses lists;
  ADDRESS(Records) records;
  ADDRESS(KeptCounts) kept;
  ADDRESS(StateQuads) state;
  uint width, height;
};

// Of passes over pixels that merge the fragments kept: part after part, each pass with what the one before left in the state.
struct OrderedMergePush {
  ListAddresses lists;
  ADDRESS(ListedSurfaces) surfaces;
  ADDRESS(KeptCounts) kept;
  ADDRESS(StateQuads) state;
  uint width, height;
  uint part;  // which SUBPIXEL_LIST_PART of them
};

#ifdef __cplusplus
static_assert(sizeof(OrderedKeepPush) == 64);
static_assert(sizeof(OrderedMergePush) == 72);
}  // namespace subpixel::gpu_types
#endif
#endif
