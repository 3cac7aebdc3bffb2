#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
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

#ifdef STORY
#include "techniques/smaa/story_interface.h"
layout(set = 0, binding = STORAGE(SMAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, how many
  SmaaEdgesStory story[SMAA_STORY_PIXELS];
};
void tell_edges(vec4 steps, vec3 more, uint edges) {
  ivec2 from = ivec2(gl_FragCoord.xy) - ivec2(told.xy);
  for (bool tell = from.x + from.y <= 1; tell; tell = false) {
    story[from.x + 2 * from.y].steps = steps;
    story[from.x + 2 * from.y].more = vec4(more, 0.0);
    story[from.x + 2 * from.y].head = uvec4(edges, 1u, 0u, 0u);
    told.z = SMAA_STORY_PIXELS;
  }
}
#define TELL(what) what
#else
#define TELL(what)
#endif

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
  TELL(tell_edges(vec4(to_west, to_north, to_east, to_south), vec3(beyond_west, beyond_north, most), edges);)
  out_edges = edges;
}
