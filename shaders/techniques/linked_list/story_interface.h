// What host and the passes agree on that tell where the fragments of one pixel are stored.
#ifndef SUBPIXEL_LINKED_LIST_STORY_INTERFACE_H
#define SUBPIXEL_LINKED_LIST_STORY_INTERFACE_H

#include "linked_list_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define LINK_SLOT_STORY 5  // storage: the header, then LinkPlace of link.comp or LinkStoredBlock of story.comp

// A fragment that needs a dynamic block.
struct LinkPlace {
  uvec4 of;  // the sample that stands for it, samples, its place among all dynamic blocks, the block before it
};

// A block with a surface, in the order of the list.
struct LinkStoredBlock {
  uvec4 of;       // number, samples that it counts as, the one it is known by, the pointer to it: 0 of the own
  uvec4 surface;  // as in packing.glsl
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
