// What host and the pass agree on that tells how decoupled coverage merges one pixel.
#ifndef SUBPIXEL_DCAA_STORY_INTERFACE_H
#define SUBPIXEL_DCAA_STORY_INTERFACE_H

#include "dcaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define DCAA_SLOT_STORY 4  // storage: the header, then a step for each fragment that was kept

struct DcaaStorySurface {
  uvec4 words;     // coverage, facet word, depth bits
  uvec4 more;      // albedo, normal, roughness, emission
  vec4 facet;      // its normal; depth
  vec4 interval;   // farthest and nearest depth; cosine to the step's fragment, share of the shorter interval or -1
};

struct DcaaStep {
  uvec4 head;                                 // the fragment's number; count word before and after it
  DcaaStorySurface fragment;                  // as it came, its coverage what it brings
  DcaaStorySurface before[DCAA_MAX_SURFACES]; // slot after slot
  DcaaStorySurface after[DCAA_MAX_SURFACES];
};

#ifdef __cplusplus
static_assert(sizeof(DcaaStep) == 16 + 64 * (1 + 2 * DCAA_MAX_SURFACES));
}  // namespace subpixel::gpu_types
#endif
#endif
