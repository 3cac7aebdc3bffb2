#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The clustering of the aggregate technique fed with samples of its own: one invocation for each pixel.
// Reads: SAMPLES positions and normals for each pixel, covered samples. Writes: membership planes and the number of aggregates.
layout(local_size_x = 64) in;
#include "tests/agaa_test_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
struct Given {
  vec3 position, normal;
};
layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_SAMPLES), scalar) readonly buffer Samples { Given given[]; };
layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_COVERED), scalar) readonly buffer Covered { uint covered[]; };
layout(set = 0, binding = STORAGE(AGAA_TEST_SLOT_RESULTS), scalar) writeonly buffer Results { uvec3 results[]; };
layout(push_constant, scalar) uniform Push { AgaaTestClusterPush push; };

#include "techniques/agaa/cluster.glsl"

uint pixel;
ClusterSample cluster_sample(uint s) {
  Given g = given[pixel * SAMPLES + s];
  return ClusterSample(g.position, g.normal);
}

void main() {
  pixel = gl_GlobalInvocationID.x;
  if (pixel >= push.pixels) return;
  Clusters c = cluster_pixel(covered[pixel], push.separation);
  results[pixel] = uvec3(c.low, c.high, c.count);
}
