// What host and shaders agree on that tell what happens in one pixel.
#ifndef SUBPIXEL_STORY_INTERFACE_H
#define SUBPIXEL_STORY_INTERFACE_H

#include "../frontend/frontend_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Storage.
#define STORY_SLOT_FRAGMENTS 1  // of fragments.comp
#define STORY_SLOT_LIGHTING 7   // of passes that light, a LightingLog

#define STORY_MOST_EXECUTIONS 64

// A fragment of the pixel as the front-end gives it to every technique.
struct StoryFragment {
  uvec4 masks;    // samples that the triangle covers in xy, those of them that alpha leaves in zw
  vec4 plane;     // reversed depth at the pixel's centre, its change per pixel in x and y, the triangle's smallest
  // The triangle's largest depth; where attributes are evaluated, pixels from the centre; 1: its edges reach the pixel.
  vec4 more;
  uvec4 surface;  // as in packing.glsl
  float depths[64];  // at the samples
};

struct LightingExecution {
  uvec4 of;       // the sample or slot that is lit; how many samples it counts as; which, or the one it is known by
  vec4 position;  // world
  vec4 value;     // what it contributes to each of them
};

struct LightingLog {
  uvec4 head;  // pixel, executions
  LightingExecution execution[STORY_MOST_EXECUTIONS];
};

#ifdef __cplusplus
static_assert(sizeof(StoryFragment) == 320);
static_assert(sizeof(LightingLog) == 16 + 48 * STORY_MOST_EXECUTIONS);
}  // namespace subpixel::gpu_types
#endif
#endif
