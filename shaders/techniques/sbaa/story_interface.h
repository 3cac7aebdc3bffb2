// What host and the passes agree on that tell which surfaces one pixel is found to have.
#ifndef SUBPIXEL_SBAA_STORY_INTERFACE_H
#define SUBPIXEL_SBAA_STORY_INTERFACE_H

#include "sbaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

#define SBAA_SLOT_STORY 5  // storage: the header, then SbaaStep of analyse.frag or SbaaKept of shade.frag

// A group of samples of one hash.
struct SbaaStep {
  uvec4 head;       // its samples, the first of them, the surface it goes into, how many surfaces there were
  vec4 face;        // normal of the first sample's triangle; its slope
  vec4 depth;       // of the first sample
  vec4 compared[32];  // with each of the surfaces, where they may merge: cosine of normals, farthest and nearest depth
};

// A surface that is lit.
struct SbaaKept {
  uvec4 head;     // slot, first sample, how many
  uvec4 surface;  // as in packing.glsl
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
