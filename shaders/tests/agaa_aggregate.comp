#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sums up one aggregate from surfaces of one sample each, and shades it; one invocation for each aggregate of all SAMPLES samples.
// Reads: SAMPLES surfaces for each aggregate, views, frame constants, shadow map.
// Writes: the aggregate's means as shading sees them; the radiance of the aggregate, the mean radiance of its surfaces, and the
// radiance of one surface with their mean attributes.
layout(local_size_x = 64) in;
#include "tests/agaa_test_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/agaa/shading.glsl"

layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_SURFACES), scalar) readonly buffer Surfaces {
  AgaaTestSurface surfaces[];
};
layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_VIEWS), scalar) readonly buffer Views { vec4 views[]; };
layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_RESULTS), scalar) writeonly buffer Results {
  AgaaTestResult results[];
};
layout(push_constant, scalar) uniform Push { AgaaTestPush push; };

Surface surface_of(AgaaTestSurface given) {
  Surface s;
  s.position = given.position.xyz;
  s.normal = given.normal_roughness.xyz;
  s.roughness = given.normal_roughness.w;
  s.albedo = given.albedo_metallic.rgb;
  s.metallic = given.albedo_metallic.a;
  s.occlusion = 1.0;
  s.emissive = given.emission.rgb;
  return s;
}

// The shadow of a surface is not looked up but given.
float lit_of(uint surface) { return surfaces[surface].emission.w; }

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index >= push.count) return;
  vec3 view = views[index].xyz;
  AggregateWords sums;
  for (uint i = 0u; i < AGAA_MAX_WORDS; ++i) sums.word[i] = 0u;
  vec3 brute = vec3(0.0);
  float square = 0.0;  // of the distances from the mean position
  for (uint k = 0u; k < SAMPLES; ++k) {
    Surface s = surface_of(surfaces[index * SAMPLES + k]);
    AggregateWords more = fragment_words(s, view, lit_of(index * SAMPLES + k), 1u << k, k, 1.0 / push.largest_emission);
    for (uint i = 0u; i < kAggregateWords; ++i) sums.word[i] = sum_of_words(i, sums.word[i], more.word[i]);
    brute += shade(s, view) * lit_of(index * SAMPLES + k) / float(SAMPLES);
    square += dot(s.position, s.position) / float(SAMPLES);
  }
  float roughness = surfaces[index * SAMPLES].normal_roughness.w;
  Aggregate a = aggregate_of_words(sums, roughness, push.largest_emission);
  Footprint footprint;
  footprint.mean = vec3(0.0);
  vec3 line = surfaces[index * SAMPLES].position.xyz;
  footprint.axis = vec3[3](line * (sqrt(square) / max(length(line), 1e-20)), vec3(0.0), vec3(0.0));
  Surface plain;
  plain.position = vec3(0.0);
  plain.normal = a.normal;
  plain.roughness = a.roughness;
  plain.metallic = surfaces[index * SAMPLES].albedo_metallic.a;
  plain.albedo = surfaces[index * SAMPLES].albedo_metallic.rgb;
  plain.occlusion = 1.0;
  plain.emissive = a.emissive;
  AgaaTestResult r;
  r.normal_roughness = vec4(a.normal, a.roughness);
  r.diffuse_mask = vec4(a.diffuse, uintBitsToFloat(a.mask));
  r.reflectance = vec4(a.reflectance, 0.0);
  r.emission = vec4(a.emissive, 0.0);
  r.moments = vec4(a.moments, 0.0);
  r.mixed_moments = vec4(a.mixed_moments, 0.0);
  r.slopes = vec4(a.slope, 0.0, 0.0);
  r.slope_moments = vec4(a.slope_moments, 0.0);
  r.lit_diffuse = vec4(a.lit_diffuse, 0.0);
  r.lit_reflectance = vec4(a.lit_reflectance, 0.0);
  r.filtered = vec4(shade_aggregate(a, footprint, view), 0.0);
  r.brute = vec4(brute, 0.0);
  r.plain = vec4(shade(plain, view), 0.0);
  results[index] = r;
}
