#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Where the triangle buffer does not reach.
// Reads: listed fragments, the triangle buffer. Writes: how many of a pixel's fragments go back to vertices.
#include "include/frame.glsl"
#include "include/coverage.glsl"
#include "frontend/fragment_lists.glsl"
#include "techniques/dais/triangles.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_LISTS), scalar) readonly buffer Lists { ListAddresses lists; };
layout(location = 0) out uint out_from_vertices;

void main() {
  // Helper invocations beyond the border read, too.
  ivec2 pixel = min(pixel_of(gl_FragCoord.xy), band_size() - 1);
  uvec2 range = list_range(lists, uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x));
  uint count = 0u, first;
  for (uint i = range.x; i < range.y; ++i)
    count += has_planes(triangles, lists.numbers.number[i], first) ? 0u : 1u;
  out_from_vertices = count;
}
