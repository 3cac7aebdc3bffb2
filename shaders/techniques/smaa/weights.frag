#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// How much of each other the pixels on both sides of an edge take: the areas between the edge and the line that its
// pattern stands for.
// Reads: edges; the table of areas. Writes: four weights of 8 bits, from the lowest: of the pixel and of its northern
// neighbour at the north edge, of the pixel and of its western neighbour at the west edge.
#include "techniques/smaa/smaa_interface.h"

layout(set = 0, binding = SAMPLED(SMAA_SLOT_EDGES)) uniform usampler2D edges;
layout(set = 0, binding = STORAGE(SMAA_SLOT_AREAS), scalar) readonly buffer Areas { vec2 areas[]; };
layout(push_constant, scalar) uniform Push { SmaaWeightsPush push; };

layout(location = 0) out uint out_weights;

#ifdef STORY
#include "techniques/smaa/story_interface.h"
layout(set = 0, binding = STORAGE(SMAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, how many
  SmaaWeightsStory story[SMAA_STORY_PIXELS];
};
// Which of the story's pixels this is; SMAA_STORY_PIXELS: none.
int told_number() {
  ivec2 from = ivec2(gl_FragCoord.xy) - ivec2(told.xy);
  return from.x + from.y <= 1 ? from.x + 2 * from.y : SMAA_STORY_PIXELS;
}
void tell_line(int which, ivec2 distances, uvec2 crossed, vec2 found, vec2 factors) {
  int at = told_number();
  for (bool tell = at < SMAA_STORY_PIXELS; tell; tell = false) {
    story[at].head.x |= which == 0 ? SMAA_TOLD_LEVEL : SMAA_TOLD_UPRIGHT;
    story[at].line[which] = uvec4(distances, crossed);
    story[at].line_areas[which] = vec4(found, factors);
  }
}
void tell_diagonal(int which, ivec2 distances, uvec2 crossed, vec2 found) {
  int at = told_number();
  for (bool tell = at < SMAA_STORY_PIXELS; tell; tell = false) {
    story[at].head.x |= which == 0 ? SMAA_TOLD_RISING : SMAA_TOLD_FALLING;
    story[at].diagonal[which] = uvec4(distances, crossed);
    story[at].diagonal_areas[which] = vec4(found, 0.0, 0.0);
  }
}
void tell_weights(vec4 weights, uint bytes) {
  int at = told_number();
  for (bool tell = at < SMAA_STORY_PIXELS; tell; tell = false) {
    story[at].weights = weights;
    story[at].head.yz = uvec2(bytes, 1u);
    told.z = SMAA_STORY_PIXELS;
  }
}
#define TELL(what) what
#else
#define TELL(what)
#endif

// Outside of the image the border's edges go on, as a sampler that clamps has it.
bool edge_at(ivec2 p, uint edge) {
  return (texelFetch(edges, clamp(p, ivec2(0), textureSize(edges, 0) - 1), 0).r & edge) != 0u;
}

// An edge along x is a pixel's north edge and is crossed by west edges; along y it is the other way round.
struct Direction {
  ivec2 along, across;
  uint edge, crossing;
};
const Direction LEVEL = Direction(ivec2(1, 0), ivec2(0, 1), SMAA_EDGE_NORTH, SMAA_EDGE_WEST);
const Direction UPRIGHT = Direction(ivec2(0, 1), ivec2(1, 0), SMAA_EDGE_WEST, SMAA_EDGE_NORTH);

// What crosses the line at the lower end of pixel `p` of it.
uint crossing_at(ivec2 p, Direction line) {
  return (edge_at(p - line.across, line.crossing) ? SMAA_CROSSED_BEFORE : 0u) |
         (edge_at(p, line.crossing) ? SMAA_CROSSED_AFTER : 0u);
}

// Pixels from `p` to the last one of its line, backwards or forwards. The published search goes two pixels a step and
// begins backwards with the pixel itself, forwards with the next one.
int reach(ivec2 p, Direction line, bool forwards) {
  int most = int(2u * push.search_steps) - (forwards ? 0 : 1);
  int reached = 0;
  for (bool more = most > 0; more;) {
    ivec2 next = p + (forwards ? reached + 1 : -(reached + 1)) * line.along;
    ivec2 boundary = forwards ? next : p - reached * line.along;
    more = crossing_at(boundary, line) == 0u && edge_at(next, line.edge);
    reached += more ? 1 : 0;
    more = more && reached < most;
  }
  return reached;
}

vec2 area_entry(uint pattern, uvec2 distances) {
  return areas[(pattern * SMAA_AREA_DISTANCES + distances.x) * SMAA_AREA_DISTANCES + distances.y];
}

// The table has the areas at squares, between which they are interpolated.
vec2 line_areas(uint before, uint after, ivec2 distances) {
  vec2 place = sqrt(vec2(distances));
  uvec2 low = min(uvec2(place), uvec2(SMAA_AREA_DISTANCES - 2));
  vec2 share = place - vec2(low);
  uint pattern = before * 4u + after;
  vec2 first = mix(area_entry(pattern, low), area_entry(pattern, low + uvec2(0, 1)), share.y);
  vec2 second = mix(area_entry(pattern, low + uvec2(1, 0)), area_entry(pattern, low + uvec2(1, 1)), share.y);
  return mix(first, second, share.x);
}

// "Sharp geometric features": an edge that goes on across the line's end is a corner, which keeps its shape but for `rounding`.
vec2 corner_factors(ivec2 first, ivec2 last, Direction line, ivec2 distances) {
  vec2 near = vec2(distances.x <= distances.y, distances.y <= distances.x);
  vec2 kept = (1.0 - push.rounding) * near / (near.x + near.y);
  ivec2 past = last + line.along, far = 2 * line.across;
  vec2 lost = vec2(0.0);
  if (edge_at(first + line.across, line.crossing)) lost.x += kept.x;
  if (edge_at(past + line.across, line.crossing)) lost.x += kept.y;
  if (edge_at(first - far, line.crossing)) lost.y += kept.x;
  if (edge_at(past - far, line.crossing)) lost.y += kept.y;
  return clamp(1.0 - lost, 0.0, 1.0);
}

// Of the pixel and of its neighbour across the edge.
vec2 line_weights(ivec2 p, Direction line) {
  ivec2 distances = ivec2(reach(p, line, false), reach(p, line, true));
  ivec2 first = p - distances.x * line.along, last = p + distances.y * line.along;
  vec2 found = line_areas(crossing_at(first, line), crossing_at(last + line.along, line), distances);
  TELL(tell_line(line.along.x == 1 ? 0 : 1, distances,
                 uvec2(crossing_at(first, line), crossing_at(last + line.along, line)), found,
                 corner_factors(first, last, line, distances));)
  return found * corner_factors(first, last, line, distances);
}

// A staircase's two edges of each step: of a rising one, both are the pixel's; of a falling one, the second is its eastern
// neighbour's.
bvec2 step_edges(ivec2 p, bool falling) {
  return bvec2(edge_at(p, SMAA_EDGE_NORTH), edge_at(falling ? p + ivec2(1, 0) : p, SMAA_EDGE_WEST));
}

// How far a staircase goes from `p` in `direction`, and whether its end was found; half a step more where the last one
// has a north edge, if `whole_end`.
int staircase(ivec2 p, ivec2 direction, bool falling, bool whole_end, out bool ends) {
  int steps = 0;
  bvec2 last = bvec2(true);
  for (bool more = true; more;) {
    ++steps;
    last = step_edges(p + steps * direction, falling);
    more = all(last) && steps < int(push.diagonal_steps);
  }
  ends = !all(last);
  return steps - 1 + (whole_end && last.x ? 1 : 0);
}

vec2 diagonal_areas(uint before, uint after, ivec2 distances) {
  const int size = SMAA_DIAGONAL_DISTANCES;
  ivec2 d = min(distances, ivec2(size - 1));
  return areas[16 * SMAA_AREA_DISTANCES * SMAA_AREA_DISTANCES + (int(before * 4u + after) * size + d.x) * size + d.y];
}

uint crossings(bool first, bool second) { return (first ? 2u : 0u) | (second ? 1u : 0u); }

// "Diagonal patterns": of the pixel and of its northern neighbour. Staircases of one step are lines of the other kind.
vec2 diagonal_weights(ivec2 p) {
  vec2 weights = vec2(0.0);
  const ivec2 east = ivec2(1, 0), north = ivec2(0, -1);
  bool ends_before = false, ends_after = false;
  // Rising to the right.
  ivec2 d = ivec2(0);
  if (edge_at(p, SMAA_EDGE_WEST)) d.x = staircase(p, ivec2(-1, 1), false, true, ends_before);
  else ends_before = true;
  d.y = staircase(p, ivec2(1, -1), false, false, ends_after);
  if (d.x + d.y > 2) {
    ivec2 first = p + d.x * ivec2(-1, 1), last = p + d.y * ivec2(1, -1);
    uint before = crossings(edge_at(first - east, SMAA_EDGE_NORTH), edge_at(first, SMAA_EDGE_WEST));
    uint after = crossings(edge_at(last + east, SMAA_EDGE_NORTH), edge_at(last + east + north, SMAA_EDGE_WEST));
    weights += diagonal_areas(ends_before ? before : 0u, ends_after ? after : 0u, d);
    TELL(tell_diagonal(0, d, uvec2(ends_before ? before : 0u, ends_after ? after : 0u), weights);)
  }
  // Falling.
  d = ivec2(0);
  d.x = staircase(p, ivec2(-1, -1), true, false, ends_before);
  if (edge_at(p + east, SMAA_EDGE_WEST)) d.y = staircase(p, ivec2(1, 1), true, true, ends_after);
  else ends_after = true;
  if (d.x + d.y > 2) {
    ivec2 first = p - d.x * ivec2(1, 1), last = p + d.y * ivec2(1, 1);
    uint before = crossings(edge_at(first - east, SMAA_EDGE_NORTH), edge_at(first + north, SMAA_EDGE_WEST));
    uint after = crossings(edge_at(last + east, SMAA_EDGE_NORTH), edge_at(last + east, SMAA_EDGE_WEST));
    weights += diagonal_areas(ends_before ? before : 0u, ends_after ? after : 0u, d).yx;
    TELL(tell_diagonal(1, d, uvec2(ends_before ? before : 0u, ends_after ? after : 0u),
                       diagonal_areas(ends_before ? before : 0u, ends_after ? after : 0u, d).yx);)
  }
  return weights;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  bool north = edge_at(p, SMAA_EDGE_NORTH), west = edge_at(p, SMAA_EDGE_WEST);
  vec4 weights = vec4(0.0);
  bool diagonal = false;
  if (north) {
    if (push.diagonal_steps > 0u) weights.xy = diagonal_weights(p);
    diagonal = weights.x + weights.y > 0.0;
    if (!diagonal) weights.xy = line_weights(p, LEVEL);
  }
  if (west && !diagonal) weights.zw = line_weights(p, UPRIGHT);
  uvec4 bytes = uvec4(clamp(weights, 0.0, 1.0) * 255.0 + 0.5);
  out_weights = bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24;
  TELL(tell_weights(weights, out_weights);)
}
