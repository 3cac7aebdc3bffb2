// A stream that a test feeds to decoupled coverage anti-aliasing. Included by host and shader.
#ifndef SUBPIXEL_DCAA_TEST_INTERFACE_H
#define SUBPIXEL_DCAA_TEST_INTERFACE_H

#include "../techniques/dcaa/dcaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Storage.
#define DCAA_TEST_SLOT_RANGES 0
#define DCAA_TEST_SLOT_FRAGMENTS 1
#define DCAA_TEST_SLOT_VIEW 2
#define DCAA_TEST_SLOT_WORDS 3  // the pixels' states

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
