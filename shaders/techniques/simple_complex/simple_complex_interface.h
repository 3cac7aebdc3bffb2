// What host and the passes over simple and complex pixels agree on.
#ifndef SUBPIXEL_SIMPLE_COMPLEX_INTERFACE_H
#define SUBPIXEL_SIMPLE_COMPLEX_INTERFACE_H

#include "../../deferred/deferred_interface.h"
#include "../../frontend/frontend_interface.h"
#include "../../shade/shade_interface.h"

// Sampled.
#define SIMPLE_COMPLEX_SLOT_FLAGS 2
// Storage image.
#define SIMPLE_COMPLEX_SLOT_SUM 0

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct SimpleComplexClassifyPush {
  ADDRESS(Records) records;
  float depth_scale;
  float least_cosine;
};

#ifdef __cplusplus
}  // namespace subpixel::gpu_types
#endif
#endif
