// What tests and the shaders that they feed agree on. Those of single techniques have headers of their own.
#ifndef SUBPIXEL_TEST_INTERFACE_H
#define SUBPIXEL_TEST_INTERFACE_H

#include "../include/interface.h"

// Storage.
#define TEST_SLOT_SAMPLES 0  // of pixels, read or written
#define TEST_SLOT_SLOPES 1   // of the triangle of each pixel's sample 0
#define TEST_SLOT_MASKS 2
#define TEST_SLOT_COMPLEX 2
#define TEST_SLOT_PROBES 0
#define TEST_SLOT_RADIANCES 1
// Sampled.
#define TEST_SLOT_IMAGE 0

#ifdef __cplusplus
namespace subpixel::gpu_types {
#endif

struct AnalysedTestSample {
  vec3 normal;
  float depth;
  float slope;
  uint triangle;
};

struct AnalyseTestPush {
  uint pixels;
  uint keep;
  uint merge;
  float cosine;
};

struct ClassifiedTestSample {
  vec3 normal;
  float depth;
  uint triangle;
  uint material;
};

struct ClassifyTestPush {
  uint pixels;
  float depth_scale;
  float least_cosine;
};

// A surface to light.
struct TestProbe {
  vec4 position_roughness;
  vec4 normal_metallic;
  vec4 albedo_occlusion;
  vec4 emissive;
  vec4 view;
};

struct ProbeTestPush {
  uint count;
};

#ifdef __cplusplus
static_assert(sizeof(AnalysedTestSample) == 24);
static_assert(sizeof(ClassifiedTestSample) == 24);
static_assert(sizeof(TestProbe) == 80);
}  // namespace subpixel::gpu_types
#endif
#endif
