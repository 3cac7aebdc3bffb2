// Streams that a test feeds to the streaming compression. Included by host and shaders.
#ifndef SUBPIXEL_STREAMING_TEST_INTERFACE_H
#define SUBPIXEL_STREAMING_TEST_INTERFACE_H

#include "../techniques/streaming/streaming_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Storage.
#define STREAM_TEST_SLOT_RANGES 0
#define STREAM_TEST_SLOT_FRAGMENTS 1
#define STREAM_TEST_SLOT_QUADS 2     // the pixels' states
#define STREAM_TEST_SLOT_OF_FRAME 1  // the fragments of a frame, of a pass over lists

struct StreamTestFragment {
  vec4 plane;   // reversed depth: at the pixel's centre, dz/dx, dz/dy, smallest of the triangle
  vec4 depth;   // the surface's depth and its slopes, if they are not packed; w: largest reversed depth of the triangle
  uvec4 words;  // coverage, albedo, normal, roughness
  uvec4 more;   // emission; of a frame's fragments, packed slopes and pixel x | y << 16
};

#ifdef __cplusplus
static_assert(sizeof(StreamTestFragment) == 64);
}  // namespace subpixel::gpu_types
#endif
#endif
