#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Classifies given pixels, for the test of the classification.
// Reads: samples and triangles of each pixel. Writes: 1 for each complex one.
layout(local_size_x = 64) in;
#include "tests/test_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;

layout(set = 0, binding = STORAGE(TEST_SLOT_SAMPLES), scalar) readonly buffer Samples { ClassifiedTestSample samples[]; };
layout(set = 0, binding = STORAGE(TEST_SLOT_SLOPES), scalar) readonly buffer Slopes { vec2 slopes[]; };  // of sample 0's triangle
layout(set = 0, binding = STORAGE(TEST_SLOT_COMPLEX), scalar) writeonly buffer Complex { uint complex[]; };
layout(push_constant, scalar) uniform Push { ClassifyTestPush push; };

#include "techniques/simple_complex/classification.glsl"

uint place(uint s) { return gl_GlobalInvocationID.x * SAMPLES + s; }

uvec4 quad_triangles(uint quad) {
  uint s = place(4u * quad);
  return uvec4(samples[s].triangle, samples[s + 1u].triangle, samples[s + 2u].triangle, samples[s + 3u].triangle);
}
vec4 quad_depths(uint quad) {
  uint s = place(4u * quad);
  return vec4(samples[s].depth, samples[s + 1u].depth, samples[s + 2u].depth, samples[s + 3u].depth);
}
ClassifiedSurface sample_surface(uint s) { return ClassifiedSurface(samples[place(s)].normal, samples[place(s)].material); }
vec2 triangle_slopes(uint triangle) { return slopes[gl_GlobalInvocationID.x]; }

void main() {
  if (gl_GlobalInvocationID.x >= push.pixels) return;
  complex[gl_GlobalInvocationID.x] = pixel_is_complex(push.depth_scale, push.least_cosine) ? 1u : 0u;
}
