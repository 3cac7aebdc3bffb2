#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 1=-DGROUP=1 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16 1A=-DGROUP=1,-DWITH_UV 4A=-DGROUP=4,-DWITH_UV 8A=-DGROUP=8,-DWITH_UV 16A=-DGROUP=16,-DWITH_UV
// Nearest triangle of each sample: depth and triangle number of GROUP samples of the pattern, in primitive order, so that of
// equal depths the first submitted stays.
// Reads and writes: the attachments. GROUP 1: one of (depth bits, triangle); else GROUP / 4 of depth bits, then GROUP / 4 of
// triangles, four samples in each. Reversed depths are not negative, so their bits compare like the numbers.
#include "frontend/fragment.glsl"

#if GROUP == 1
layout(input_attachment_index = 0, set = 0, binding = 24) uniform usubpassInput in_state;
layout(location = 0) out uvec4 out_state;
#else
layout(input_attachment_index = 0, set = 0, binding = 24) uniform usubpassInput in_depth0;
layout(location = 0) out uvec4 out_depth0;
#if GROUP == 4
layout(input_attachment_index = 1, set = 0, binding = 25) uniform usubpassInput in_id0;
layout(location = 1) out uvec4 out_id0;
#elif GROUP == 8
layout(input_attachment_index = 1, set = 0, binding = 25) uniform usubpassInput in_depth1;
layout(input_attachment_index = 2, set = 0, binding = 26) uniform usubpassInput in_id0;
layout(input_attachment_index = 3, set = 0, binding = 27) uniform usubpassInput in_id1;
layout(location = 1) out uvec4 out_depth1;
layout(location = 2) out uvec4 out_id0;
layout(location = 3) out uvec4 out_id1;
#else
layout(input_attachment_index = 1, set = 0, binding = 25) uniform usubpassInput in_depth1;
layout(input_attachment_index = 2, set = 0, binding = 26) uniform usubpassInput in_depth2;
layout(input_attachment_index = 3, set = 0, binding = 27) uniform usubpassInput in_depth3;
layout(input_attachment_index = 4, set = 0, binding = 28) uniform usubpassInput in_id0;
layout(input_attachment_index = 5, set = 0, binding = 29) uniform usubpassInput in_id1;
layout(input_attachment_index = 6, set = 0, binding = 30) uniform usubpassInput in_id2;
layout(input_attachment_index = 7, set = 0, binding = 31) uniform usubpassInput in_id3;
layout(location = 1) out uvec4 out_depth1;
layout(location = 2) out uvec4 out_depth2;
layout(location = 3) out uvec4 out_depth3;
layout(location = 4) out uvec4 out_id0;
layout(location = 5) out uvec4 out_id1;
layout(location = 6) out uvec4 out_id2;
layout(location = 7) out uvec4 out_id3;
#endif
#endif

layout(constant_id = 4) const uint SAMPLE_GROUP = 0u;  // which GROUP samples of the pattern

// The depths of four samples where they are covered and nearer than `stored`, else `stored`.
uvec4 nearer_depths(uvec4 stored, uint mask, uint first, DepthPlane plane) {
  uvec4 result = stored;
  for (uint i = 0u; i < 4u; ++i) {
    uint z = floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, SAMPLE_GROUP * GROUP + first + i)));
    bool nearer = (mask & (1u << (first + i))) != 0u && z > stored[i];
    result[i] = nearer ? z : stored[i];
  }
  return result;
}

uvec4 nearer_ids(uvec4 stored, uvec4 old_depth, uvec4 new_depth) {
  return mix(stored, uvec4(fragment_triangle()), notEqual(old_depth, new_depth));
}

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  PixelEdges edges = fragment_edges(pixel);
  uint mask = coverage_mask(edges, SAMPLES, SAMPLE_GROUP * GROUP, GROUP);
#ifdef WITH_UV
  for (bool go = mask != 0u; go; go = false)
    mask = alpha_mask(mask, SAMPLE_GROUP * GROUP, GROUP, pixel, shading_offset(edges, SAMPLES));
#endif
  bool changed = false;
  // Skipped, as a loop is, when no lane covers anything.
  for (bool go = mask != 0u; go; go = false) {
    DepthPlane plane = fragment_depth(pixel);
#if GROUP == 1
    uint z = floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, SAMPLE_GROUP)));
    changed = z > subpassLoad(in_state).x;
    out_state = uvec4(z, fragment_triangle(), 0u, 0u);
#else
    uvec4 old0 = subpassLoad(in_depth0), new0 = nearer_depths(old0, mask, 0u, plane);
    changed = old0 != new0;
    out_depth0 = new0;
#if GROUP >= 8
    uvec4 old1 = subpassLoad(in_depth1), new1 = nearer_depths(old1, mask, 4u, plane);
    changed = changed || old1 != new1;
    out_depth1 = new1;
#endif
#if GROUP == 16
    uvec4 old2 = subpassLoad(in_depth2), new2 = nearer_depths(old2, mask, 8u, plane);
    uvec4 old3 = subpassLoad(in_depth3), new3 = nearer_depths(old3, mask, 12u, plane);
    changed = changed || old2 != new2 || old3 != new3;
    out_depth2 = new2;
    out_depth3 = new3;
#endif
    for (bool write = changed; write; write = false) {
      out_id0 = nearer_ids(subpassLoad(in_id0), old0, new0);
#if GROUP >= 8
      out_id1 = nearer_ids(subpassLoad(in_id1), old1, new1);
#endif
#if GROUP == 16
      out_id2 = nearer_ids(subpassLoad(in_id2), old2, new2);
      out_id3 = nearer_ids(subpassLoad(in_id3), old3, new3);
#endif
    }
#endif
  }
  if (!changed) discard;
}
