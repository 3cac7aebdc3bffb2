// What host and filter agree on.
#ifndef SUBPIXEL_FXAA_INTERFACE_H
#define SUBPIXEL_FXAA_INTERFACE_H

#include "../../include/interface.h"

// Sampled.
#define FXAA_SLOT_DISPLAYED 0
#define FXAA_SLOT_VALUES 1

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct FxaaPush {
  float relative_threshold;  // of the brightest neighbour
  float least_contrast;      // display values
  float blur;                // strength of the low-pass for single pixels, 0 to 1
  uint steps;                // pixels followed along an edge in each direction
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
