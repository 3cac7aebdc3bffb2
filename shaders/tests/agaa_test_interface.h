// What the tests of aggregates and of their clustering exchange with their shaders.
#ifndef SUBPIXEL_AGAA_TEST_INTERFACE_H
#define SUBPIXEL_AGAA_TEST_INTERFACE_H

#include "../techniques/agaa/agaa_interface.h"

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

// Storage.
#define AGAA_TEST_SLOT_SURFACES 0
#define AGAA_TEST_SLOT_VIEWS 1
#define AGAA_TEST_SLOT_SAMPLES 0
#define AGAA_TEST_SLOT_COVERED 1
#define AGAA_TEST_SLOT_RESULTS 2  // of both

// Of agaa_aggregate.comp.
struct AgaaTestPush {
  uint count;
  float largest_emission;
};

// Of agaa_cluster.comp.
struct AgaaTestClusterPush {
  uint pixels;
  float separation;
};

struct AgaaTestSurface {
  vec4 normal_roughness, albedo_metallic, emission;  // emission.w: the fraction of light that arrives
  vec4 position;  // on one line through their mean, 0
};

struct AgaaTestResult {
  vec4 normal_roughness, diffuse_mask, reflectance, emission, moments, mixed_moments;  // mask: its bits
  vec4 slopes, slope_moments, lit_diffuse, lit_reflectance;
  vec4 filtered, brute, plain;
};

#ifdef __cplusplus
static_assert(sizeof(AgaaTestSurface) == 64);
static_assert(sizeof(AgaaTestResult) == 208);
}  // namespace subpixel::gpu_types
#endif
#endif
