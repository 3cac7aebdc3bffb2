// Planes of depth over a pixel, as the prepass's bound and what is compared with it (Wang et al. 2015, section 4.2). The paper
// keeps one depth a pixel; a plane also rules out a wall close behind another, however steep both are.
#ifndef SUBPIXEL_DCAA_DEPTH_BOUND_GLSL
#define SUBPIXEL_DCAA_DEPTH_BOUND_GLSL

#include "include/coverage.glsl"

// Reversed depth z at the pixel's centre and its slopes per pixel: (z, dz/dx, dz/dy).

// Half of how far the plane's depth varies over the pixel.
float plane_reach(vec2 slopes) { return 0.5 * (abs(slopes.x) + abs(slopes.y)); }

// What the rounding of sums can make of sample_depth(), and of the comparison here.
float depth_slack(vec3 a, vec3 b) {
  return (abs(a.x) + abs(b.x) + plane_reach(a.yz) + plane_reach(b.yz)) * (1.0 / 1048576.0);
}

// A plane that no sample of the fragment is farther than. Of a sliver whose plane leaves its own range, level.
vec3 farthest_plane(DepthPlane plane) {
  float reach = plane_reach(vec2(plane.dx, plane.dy));
  bool level = 2.0 * reach > plane.largest - plane.smallest;
  return level ? vec3(max(plane.centre - reach, plane.smallest), 0.0, 0.0) : vec3(plane.centre, plane.dx, plane.dy);
}

// Is some sample of the fragment perhaps not behind the bound?
bool may_show(DepthPlane plane, vec3 bound) {
  vec3 own = vec3(plane.centre, plane.dx, plane.dy);
  float slack = depth_slack(own, bound);
  float ahead = own.x - bound.x + plane_reach(own.yz - bound.yz);
  float nearest = min(plane.centre + plane_reach(own.yz), plane.largest);
  return ahead + slack >= 0.0 && nearest - (bound.x - plane_reach(bound.yz)) + slack >= 0.0;
}

// The bound, and the fragments gathered towards a nearer one: the plane below them, what they cover.
struct DepthBound {
  vec3 bound;  // z 0 at first
  vec3 gathered;
  uvec2 samples;
};

// A fragment with the farthest plane `own`, nearer than the bound, covers `mask`.
void gather_bound(inout DepthBound b, vec3 own, uvec2 mask, uvec2 whole_pixel) {
  // A fragment far in front of what is gathered starts anew: it would lose its depth by joining.
  bool joins = b.samples != uvec2(0u) && own.x - b.gathered.x <= b.gathered.x - b.bound.x;
  uvec2 samples = joins ? b.samples | mask : mask;
  vec3 below = joins ? vec3(min(b.gathered.x, own.x - plane_reach(own.yz - b.gathered.yz)), b.gathered.yz) : own;
  // A whole pixel stands for itself; what was gathered stays if it is nearer.
  bool whole = mask == whole_pixel, complete = samples == whole_pixel;
  below = whole ? own : below;
  bool better = (whole || complete) && below.x > b.bound.x;
  b.bound = better ? below : b.bound;
  bool keeps = whole && b.gathered.x > own.x;
  b.samples = keeps ? b.samples : whole || complete ? uvec2(0u) : samples;
  b.gathered = keeps ? b.gathered : below;
}

#endif
