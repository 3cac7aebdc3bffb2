#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The edges west and north of a pixel: steps of luma or colour that no stronger one beside them hides.
// Reads: display values. Writes: SMAA_EDGE_ bits.
#include "techniques/smaa/smaa_interface.h"

layout(set = 0, binding = SAMPLED(SMAA_SLOT_DISPLAYED)) uniform sampler2D displayed;
layout(push_constant, scalar) uniform Push { SmaaEdgesPush push; };

layout(location = 0) out uint out_edges;

vec3 shown(ivec2 p) { return texelFetch(displayed, clamp(p, ivec2(0), textureSize(displayed, 0) - 1), 0).rgb; }

float contrast(vec3 a, vec3 b) {
  if (push.edges == SMAA_EDGES_OF_LUMA) {
    const vec3 luma = vec3(0.2126, 0.7152, 0.0722);
    return abs(dot(a, luma) - dot(b, luma));
  }
  vec3 difference = abs(a - b);
  return max(max(difference.r, difference.g), difference.b);
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec3 here = shown(p), west = shown(p - ivec2(1, 0)), north = shown(p - ivec2(0, 1));
  float to_west = contrast(here, west), to_north = contrast(here, north);
  float to_east = contrast(here, shown(p + ivec2(1, 0))), to_south = contrast(here, shown(p + ivec2(0, 1)));
  float beyond_west = contrast(west, shown(p - ivec2(2, 0))), beyond_north = contrast(north, shown(p - ivec2(0, 2)));
  float most = max(max(max(to_west, to_east), beyond_west), max(max(to_north, to_south), beyond_north));
  uint edges = 0u;
  if (to_west >= push.threshold && push.adaptation * to_west >= most) edges |= SMAA_EDGE_WEST;
  if (to_north >= push.threshold && push.adaptation * to_north >= most) edges |= SMAA_EDGE_NORTH;
  out_edges = edges;
}
