#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Aggregate definition (AGAA paper, section 3.3): which aggregate each sample of a pixel belongs to.
// Reads: visibility (slot 0), face normals. Writes: bits 0 and 1 of every sample's aggregate.
#include "techniques/agaa/agaa_interface.h"
#include "include/packing.glsl"
#include "include/visibility.glsl"
#include "techniques/agaa/sample_position.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Faces { uint face[]; };
layout(push_constant, scalar) uniform Push { AgaaDefinePush push; };
layout(location = 0) out uvec2 out_aggregates;

#include "techniques/agaa/cluster.glsl"

ClusterSample cluster_sample(uint i) {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint triangle = visible_triangles(pixel, SAMPLES, i / 4u)[i & 3u];
  float depth = uintBitsToFloat(visible_depths(pixel, SAMPLES, i / 4u)[i & 3u]);
  vec2 offset = vec2(sample_offset(SAMPLES, i)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
  vec3 position = view_position(push.view_from_clip, frame.viewport, frame_pixel(pixel), offset, depth);
  uint face = push.faces.face[triangle == SUBPIXEL_NO_TRIANGLE ? 0u : triangle];
  return ClusterSample(position * push.inverse_length, unpack_normal(face));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint covered = 0u, first = SUBPIXEL_NO_TRIANGLE;
  bool differs = false;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    uvec4 triangles = visible_triangles(pixel, SAMPLES, quad);
    for (uint i = 0u; i < 4u; ++i) {
      bool here = triangles[i] != SUBPIXEL_NO_TRIANGLE;
      covered |= here ? 1u << 4u * quad + i : 0u;
      differs = differs || (here && first != SUBPIXEL_NO_TRIANGLE && triangles[i] != first);
      first = here ? triangles[i] : first;
    }
  }
  // One triangle is one fragment, which adds to one aggregate whatever the clustering says. A loop, so that groups of such
  // pixels skip it.
  out_aggregates = uvec2(0u);
  for (bool several = differs; several; several = false) {
    Clusters clusters = cluster_pixel(covered, push.separation);
    out_aggregates = uvec2(clusters.low, clusters.high);
  }
}
