#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Algorithm 1 fed with a stream of its own: one invocation merges one pixel.
// Reads: ranges, first fragment and count of each pixel; fragments; the camera. Writes: the pixel's state as merge.frag leaves
// it.
layout(local_size_x = 64) in;
#include "tests/dcaa_test_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#include "techniques/dcaa/merge.glsl"
#include "techniques/dcaa/state.glsl"

layout(set = 0, binding = STORAGE(DCAA_TEST_SLOT_RANGES), scalar) readonly buffer Ranges {
  uvec4 ranges[];  // zw: pixel
};
layout(set = 0, binding = STORAGE(DCAA_TEST_SLOT_FRAGMENTS), scalar) readonly buffer Stream {
  DcaaTestFragment fragments[];
};
layout(set = 0, binding = STORAGE(DCAA_TEST_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(set = 0, binding = STORAGE(DCAA_TEST_SLOT_WORDS), scalar) writeonly buffer Words { uint words[]; };

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= uint(ranges.length())) return;
  DcaaState state;
  for (uint i = 0u; i < MAX_STATE_WORDS; ++i) state.word[i] = 0u;
  DcaaSurface surface[DCAA_MAX_SURFACES];
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);
  vec3 ray = dcaa_ray(ivec2(ranges[pixel].zw), view);
  for (uint k = 0u; k < ranges[pixel].y; ++k) {
    DcaaTestFragment given = fragments[ranges[pixel].x + k];
    DcaaSurface fragment;
    fragment.coverage = given.coverage.xy;
    fragment.facet = dcaa_pack_facet(given.facet_depth.xyz);
    fragment.depth = dcaa_rounded_depth(given.facet_depth.w);
    fragment.albedo = given.words.x;
    fragment.normal = given.words.y;
    fragment.roughness = given.words.z;
    fragment.emission = 0u;
    fragment.moments = dcaa_moments_of(fragment.normal);
    dcaa_add(state.word[0], surface, fragment, ray, view);
  }
  for (uint i = 0u; i < SURFACES; ++i) dcaa_pack(surface[i], i, state);
  for (uint i = 0u; i < 4u * STATE_QUADS; ++i) words[pixel * 4u * STATE_QUADS + i] = state.word[i];
}
