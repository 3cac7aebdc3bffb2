#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Groups the samples of given pixels into surfaces, for the test of the analysis.
// Reads: samples of each pixel. Writes: the masks of its kept surfaces.
layout(local_size_x = 64) in;
#include "tests/test_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;

layout(set = 0, binding = STORAGE(TEST_SLOT_SAMPLES), scalar) readonly buffer Samples { AnalysedTestSample samples[]; };
layout(set = 0, binding = STORAGE(TEST_SLOT_MASKS), scalar) writeonly buffer Masks { uint masks[]; };
layout(push_constant, scalar) uniform Push { AnalyseTestPush push; };

#include "frontend/frontend_types.h"
#include "techniques/sbaa/analysis.glsl"

AnalysedSample analysed_sample(uint s) {
  AnalysedTestSample given = samples[gl_GlobalInvocationID.x * SAMPLES + s];
  return AnalysedSample(given.normal, given.depth, given.slope);
}

void main() {
  uint pixel = gl_GlobalInvocationID.x;
  if (pixel >= push.pixels) return;
  uint hashes[8] = uint[8](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  uint covered = 0u;
  for (uint s = 0u; s < SAMPLES; ++s) {
    uint triangle = samples[pixel * SAMPLES + s].triangle;
    hashes[s / 4u] |= primitive_hash(triangle) << 8u * (s & 3u);
    covered |= triangle != SUBPIXEL_NO_TRIANGLE ? 1u << s : 0u;
  }
  KeptSurfaces kept = analyse_pixel(hashes, covered, push.merge != 0u, push.cosine, push.keep);
  for (uint k = 0u; k < kMostSurfaces; ++k) masks[pixel * kMostSurfaces + k] = kept.mask[k];
}
