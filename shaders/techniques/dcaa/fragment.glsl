// What a fragment brings to its pixel's surfaces.
// Reads: what fragment.glsl reads. Needs fragment.glsl with attributes and surface.glsl before it.
#ifndef SUBPIXEL_DCAA_FRAGMENT_GLSL
#define SUBPIXEL_DCAA_FRAGMENT_GLSL

// The fragment's plane: its facet normal, rounded, and the depth at the pixel's centre with which it still goes through
// the triangle at `offset`.
void facet_plane(DepthPlane plane, ivec2 pixel, vec2 offset, vec3 ray, DcaaView view, inout DcaaSurface s) {
  float z = clamp(plane.centre + plane.dx * offset.x + plane.dy * offset.y, plane.smallest, plane.largest);
  float per_slope = z * view.terms.x + view.terms.y;
  vec2 g = clamp(vec2(plane.dx, plane.dy) / max(per_slope, 1e-30), -1e6, 1e6);
  // Slopes relative to the depth where the triangle is seen; the ray there is that of the centre, moved.
  vec2 at = (vec2(frame_pixel(pixel)) + offset) * view.terms.x;
  vec3 n = g.x * view.normal_x.xyz + g.y * view.normal_y.xyz + (1.0 - dot(g, at)) * view.normal_1.xyz;
  s.facet = dcaa_pack_facet(n);
  vec2 stored = dcaa_slope_factors(dcaa_facet(s.facet), ray, view);
  float away = dot(stored, offset);
  s.depth = dcaa_rounded_depth((z - view.terms.y * away) / (1.0 + view.terms.x * away));
}

// All but the coverage.
DcaaSurface dcaa_fragment(ivec2 pixel, DepthPlane plane, vec2 offset, vec3 ray, DcaaView view) {
  uvec4 packed = pack_surface(fragment_surface(pixel, offset));
  DcaaSurface fragment;
  fragment.coverage = uvec2(0u);
  facet_plane(plane, pixel, offset, ray, view, fragment);
  fragment.albedo = packed.x;
  fragment.normal = dcaa_option(DCAA_DISTRIBUTION) ? dcaa_pack_shading(unpack_normal(packed.y)) : packed.y;
  fragment.roughness = packed.z & 255u;
  fragment.emission = packed.w;
  fragment.moments = dcaa_moments_of(fragment.normal);
  return fragment;
}

#endif
