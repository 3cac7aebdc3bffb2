// What tests/technique/agaa_aggregate_test.cpp exchanges with its shader.
#ifndef SUBPIXEL_AGAA_TEST_TYPES_H
#define SUBPIXEL_AGAA_TEST_TYPES_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::vec4;
#endif

struct AgaaTestSurface {
  vec4 normal_roughness, albedo_metallic, emission;
};

struct AgaaTestResult {
  vec4 normal_roughness, diffuse_mask, reflectance, emission, moments, mixed_moments;  // mask: its bits
  vec4 filtered, brute, plain;
};

#ifdef __cplusplus
static_assert(sizeof(AgaaTestSurface) == 48);
static_assert(sizeof(AgaaTestResult) == 144);
}  // namespace subpixel::gpu_types
#endif
#endif
