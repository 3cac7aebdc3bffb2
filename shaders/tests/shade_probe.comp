// Computes: shade() of given surfaces, for the tests of lighting.
// Reads: probes, frame constants, shadow map. The push constant is the number of probes.
// Writes: one radiance for each probe; in w how bright its display value is.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
#include "include/lights.glsl"
#include "include/tone.glsl"
#include "tests/test_interface.h"

layout(set = 0, binding = STORAGE(TEST_SLOT_PROBES), std430) readonly buffer Probes { TestProbe probes[]; };
layout(set = 0, binding = STORAGE(TEST_SLOT_RADIANCES), std430) writeonly buffer Radiances { vec4 radiances[]; };
layout(push_constant, scalar) uniform Push { ProbeTestPush push; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  TestProbe p = probes[i];
  Surface s;
  s.position = p.position_roughness.xyz;
  s.normal = p.normal_metallic.xyz;
  s.albedo = p.albedo_occlusion.rgb;
  s.metallic = p.normal_metallic.w;
  s.roughness = p.position_roughness.w;
  s.occlusion = p.albedo_occlusion.w;
  s.emissive = p.emissive.rgb;
  vec3 radiance = shade(s, p.view.xyz);
  radiances[i] = vec4(radiance, display_from_radiance(radiance).g);
}
