// What host and the pass agree on that tells how streaming compresses one pixel.
#ifndef SUBPIXEL_STREAMING_STORY_INTERFACE_H
#define SUBPIXEL_STREAMING_STORY_INTERFACE_H

#include "streaming_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define STREAM_SLOT_STORY 4  // storage: the header, then a step for each fragment that passed the depth test

// A surface: depth bits, slopes, coverage, resolved; albedo, normal, roughness, emission.
struct StreamStep {
  uvec4 head;  // the fragment's number, samples that passed, count word after it, slots it may merge with
  uvec4 fragment[2];                       // as it came
  uvec4 surface[2 * STREAM_MAX_SURFACES];  // slot after slot, after it
  // Of each slot before it: cosine to its normal, nearest and farthest depth, samples shared.
  vec4 compared[STREAM_MAX_SURFACES];
  vec4 interval;  // nearest and farthest depth of the fragment
};

#ifdef __cplusplus
static_assert(sizeof(StreamStep) == 16 * 16);
}  // namespace subpixel::gpu_types
#endif
#endif
