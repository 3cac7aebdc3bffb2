// Computes: shade() of given surfaces, for the tests of lighting.
// Reads: probes, frame constants, shadow map. The push constant is the number of probes.
// Writes: one radiance for each probe; in w how bright its display value is.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "include/lights.glsl"
#include "include/tone.glsl"

struct Probe {
  vec4 position_roughness;
  vec4 normal_metallic;
  vec4 albedo_occlusion;
  vec4 emissive;
  vec4 view;
};
layout(set = 0, binding = 1, std430) readonly buffer Probes { Probe probes[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Radiances { vec4 radiances[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  Probe p = probes[i];
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
