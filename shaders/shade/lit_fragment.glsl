// What a fragment contributes to each sample that shows it, lit at one place in its pixel.
// Reads: what fragment.glsl does, shadow map, cones. Needs it with WITH_UV and WITH_ATTRIBUTES.
#ifndef SUBPIXEL_LIT_FRAGMENT_GLSL
#define SUBPIXEL_LIT_FRAGMENT_GLSL

#include "include/lights.glsl"
#include "include/resolve.glsl"

// `surface` without its position, which is `offset` pixels from the pixel's centre on the plane.
vec3 lit_surface(Surface surface, DepthPlane plane, ivec2 pixel, vec2 offset) {
  float depth = clamp(plane.centre + plane.dx * offset.x + plane.dy * offset.y, plane.smallest, plane.largest);
  surface.position = world_position(vec2(frame_pixel(pixel)) + 0.5 + offset, depth);
  return resolvable(shade(surface, normalize(frame.eye.xyz - surface.position)));
}

vec3 lit_fragment(ivec2 pixel, vec2 offset) {
  return lit_surface(fragment_surface(pixel, offset), fragment_depth(pixel), pixel, offset);
}

#endif
