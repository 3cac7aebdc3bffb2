// One fragment of a stream that a test feeds to decoupled coverage anti-aliasing. Included by host and shader.
#ifndef SUBPIXEL_DCAA_TEST_TYPES_H
#define SUBPIXEL_DCAA_TEST_TYPES_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::uvec2;
using glm::uvec4;
using glm::vec4;
#endif

struct DcaaTestFragment {
  vec4 facet_depth;  // xyz facet normal, not packed; w reversed depth at the pixel's centre
  uvec4 words;       // albedo, shading normal, roughness, unused
  uvec4 coverage;    // xy
};

#ifdef __cplusplus
static_assert(sizeof(DcaaTestFragment) == 48);
}  // namespace subpixel::gpu_types
#endif
#endif
