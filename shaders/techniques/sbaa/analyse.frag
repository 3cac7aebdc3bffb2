#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// The surfaces of each pixel, from depth, primitive and normal of its samples.
// Reads: visibility; normals and slopes of triangles.
// Writes: the kept surfaces, 16 bits each; how many they are; how many samples belong to the others.
#include "include/packing.glsl"
#include "include/visibility.glsl"
#include "techniques/sbaa/sbaa_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = SBAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
layout(constant_id = SBAA_CONSTANT_MERGE) const bool MERGE = true;
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Faces { uvec2 face[]; };
layout(push_constant, scalar) uniform Push { SbaaAnalysePush push; };
layout(location = 0) out uvec4 out_surfaces;
layout(location = 1) out uint out_count;
layout(location = 2) out uint out_dropped;

#include "techniques/sbaa/analysis.glsl"
#include "techniques/sbaa/surface_words.glsl"

AnalysedSample analysed_sample(uint s) {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint triangle = visible_triangles(pixel, SAMPLES, s / 4u)[s & 3u];
  uvec2 face = push.faces.face[triangle];
  float depth = uintBitsToFloat(visible_depths(pixel, SAMPLES, s / 4u)[s & 3u]);
  return AnalysedSample(unpack_normal(face.x), depth, uintBitsToFloat(face.y));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint hashes[8] = uint[8](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  uint covered = 0u;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    uvec4 triangles = visible_triangles(pixel, SAMPLES, quad);
    for (uint i = 0u; i < 4u; ++i) {
      hashes[quad] |= primitive_hash(triangles[i]) << 8u * i;
      covered |= triangles[i] != SUBPIXEL_NO_TRIANGLE ? 1u << 4u * quad + i : 0u;
    }
  }
  KeptSurfaces kept = analyse_pixel(hashes, covered, MERGE, push.cosine, SURFACES);
  uint words[8] = uint[8](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  uint count = 0u, shown = 0u;
  for (uint k = 0u; k < SURFACES; ++k) {
    words[k] = surface_word(kept.mask[k]);
    count += kept.mask[k] != 0u ? 1u : 0u;
    shown |= kept.mask[k];
  }
  out_surfaces = uvec4(words[0] | words[1] << 16, words[2] | words[3] << 16, words[4] | words[5] << 16, words[6] | words[7] << 16);
  out_count = count;
  out_dropped = uint(bitCount(covered & ~shown));
}
