// What host and the variant of the filter agree on that tells what it does to one pixel.
#ifndef SUBPIXEL_FXAA_STORY_INTERFACE_H
#define SUBPIXEL_FXAA_STORY_INTERFACE_H

#include "fxaa_interface.h"

#define FXAA_SLOT_STORY 5  // storage: the header, then one FxaaStory
#define FXAA_MOST_STEPS 64

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct FxaaStory {
  vec4 contrast;   // brightest and darkest of the pixel and its four neighbours, their difference, what it has to reach
  vec4 curvature;  // second differences down and to the right; 1: a level edge, 0: an upright one
  vec4 across;     // x and y to the pixel across the edge; mean of both, a quarter of their difference
  vec4 ends;       // steps to the end back and ahead, the differences of the mean there
  vec4 shares;     // of the step, of the low-pass, the larger
  vec4 own, other, mixed;  // values
  float luma[9];           // of 3x3 pixels, by rows from the north-west
  // Of each step the difference of the two sides' mean from that at the start.
  float back[FXAA_MOST_STEPS], ahead[FXAA_MOST_STEPS];
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
