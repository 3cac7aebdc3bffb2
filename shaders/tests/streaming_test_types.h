// One fragment of a stream that a test feeds to the streaming compression. Included by host and shader.
#ifndef SUBPIXEL_STREAMING_TEST_TYPES_H
#define SUBPIXEL_STREAMING_TEST_TYPES_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::uvec4;
using glm::vec4;
#endif

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
