#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// What the aggregates of each pixel are like.
// Reads: visibility (slot 0), the pixel's aggregates.
// Writes: how many; the variance of their normals in thousandths, mean over samples; the largest standard deviation of positions in
// millimetres.
#include "techniques/agaa/agaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
#include "include/visibility.glsl"
#include "techniques/agaa/shading.glsl"
#include "techniques/agaa/footprint.glsl"
#include "techniques/agaa/sums_access.glsl"

layout(push_constant, scalar) uniform Push { AgaaShadePush push; };
layout(location = 0) out uint out_aggregates;
layout(location = 1) out uint out_variance;
layout(location = 2) out uint out_footprint;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float variance = 0.0, extent = 0.0;
  uint samples = 0u, count = 0u;
  for (uint k = 0u; k < AGGREGATES; ++k) {
    AggregateWords words = stored_words(pixel, k);
    uint mask = aggregate_mask(words.word[kMaskWord]);
    for (bool stored = mask != 0u; stored; stored = false) {
      Aggregate a = aggregate_of_words(words, 0.0, 1.0);
      vec3 view;
      Footprint f = aggregate_footprint(push.view_from_clip, pixel, mask, view);
      variance += float(int(bitCount(mask))) * (1.0 - dot(a.normal, a.normal));
      extent = max(extent, sqrt(dot(f.axis[0], f.axis[0]) + dot(f.axis[1], f.axis[1]) + dot(f.axis[2], f.axis[2])));
      samples += bitCount(mask);
      ++count;
    }
  }
  out_aggregates = count;
  out_variance = uint(1000.0 * variance / float(max(samples, 1u)) + 0.5);
  out_footprint = uint(min(1000.0 * extent, 1e9) + 0.5);
}
