// What host and pass agree on.
#ifndef SUBPIXEL_TAA_INTERFACE_H
#define SUBPIXEL_TAA_INTERFACE_H

#include "../../frontend/frontend_types.h"
#include "../../include/interface.h"

// Sampled; 0 is the visibility's.
#define TAA_SLOT_VALUES 1
#define TAA_SLOT_HISTORY 2
#define TAA_SLOT_DEPTH_BEFORE 3
// Storage.
#define TAA_SLOT_MOTION 0

#define TAA_BOUNDS_NONE 0u
#define TAA_BOUNDS_CLAMP 1u
#define TAA_BOUNDS_CLIP 2u
#define TAA_BOUNDS_VARIANCE 3u
#define TAA_BILINEAR 0u
#define TAA_CATMULL_ROM 1u

BUFFER_REFERENCE(TaaRecords)

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct TaaPush {
  ADDRESS(TaaRecords) records;
  vec2 unjitter;          // FrameMotion
  vec4 distance_before;   // FrameMotion
  uint still;             // number of the matrix of what does not move
  uint has_history;       // 0: the first frame
  uint bounds;            // TAA_BOUNDS_
  uint reading;           // TAA_BILINEAR, TAA_CATMULL_ROM
  uint compress;          // 1: values are weighted by 1 / (1 + luma)
  uint progressive;       // 1: the first frames are averaged
  float alpha;            // share of the new frame
  float deviations;       // half the width of the bounds of variance
  uint depth_test;        // 1: history of what was hidden is rejected
  float depth_tolerance;  // of the distance
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
