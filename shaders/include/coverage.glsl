// Exact coverage of the samples of one pixel by one snapped triangle, and its depth at a sample.
// Reads: nothing. Every pass that decides coverage or depth calls these functions, so the decisions agree bit for bit.
//
// With vertices on a 1/256 pixel grid, positive area and y down, the edge function of v0 -> v1 at a point,
//   E(x, y) = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0),
// is positive inside. Samples lie 2 k / 256 pixel from the centre (k an integer), so
//   E(sample) >= 0  <=>  floor(E(centre) / 2) + A kx + B ky >= 0,   A = -(y1 - y0), B = x1 - x0,
// all in 32 bits once the first term is clamped to a range the others can't leave. The centre's value is computed in
// doubles, which hold it exactly: |x|, |y| < 2^23.
#ifndef SUBPIXEL_COVERAGE_GLSL
#define SUBPIXEL_COVERAGE_GLSL

#include "frontend/frontend_types.h"
#include "frontend/sample_patterns.h"

struct PixelEdges {
  ivec3 base, a, b;
};

int edge_base(ivec2 from, ivec2 along, ivec2 point) {
  // Top-left rule: a sample on an edge counts when the edge is a left edge (going up) or a top edge (level, going right).
  bool inclusive = along.y < 0 || (along.y == 0 && along.x > 0);
  double value = double(along.x) * double(point.y - from.y) - double(along.y) * double(point.x - from.x);
  value = floor((value - (inclusive ? 0.0LF : 1.0LF)) * 0.5LF);
  return int(clamp(value, -1073741824.0LF, 1073741824.0LF));
}

PixelEdges pixel_edges(ivec2 v0, ivec2 v1, ivec2 v2, ivec2 pixel) {
  ivec2 point = pixel * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2;
  ivec2 d0 = v1 - v0, d1 = v2 - v1, d2 = v0 - v2;
  PixelEdges edges;
  edges.base = ivec3(edge_base(v0, d0, point), edge_base(v1, d1, point), edge_base(v2, d2, point));
  edges.a = -ivec3(d0.y, d1.y, d2.y);
  edges.b = ivec3(d0.x, d1.x, d2.x);
  return edges;
}

bool covers(PixelEdges edges, ivec2 offset) {
  ivec3 e = edges.base + edges.a * offset.x + edges.b * offset.y;
  return (e.x | e.y | e.z) >= 0;
}

// Mask of samples [first, first + count) of the n-sample pattern, sample first + i in bit i.
uint coverage_mask(PixelEdges edges, uint n, uint first, uint count) {
  uint mask = 0u;
  for (uint i = 0u; i < count; ++i) mask |= covers(edges, sample_offset(n, first + i)) ? 1u << i : 0u;
  return mask;
}

struct DepthPlane {
  float centre, dx, dy, smallest, largest;  // at the pixel's centre; per pixel; over the triangle
};

// `depth`, `depth2`: as in TriangleRecord; `reference`: its reference pixel.
DepthPlane depth_plane(uvec4 depth, uint depth2, ivec2 reference, ivec2 pixel) {
  DepthPlane plane;
  plane.dx = uintBitsToFloat(depth.y);
  plane.dy = uintBitsToFloat(depth.z);
  vec2 away = vec2(pixel - reference);
  plane.centre = fma(plane.dx, away.x, fma(plane.dy, away.y, uintBitsToFloat(depth.x)));
  plane.smallest = uintBitsToFloat(depth.w);
  plane.largest = uintBitsToFloat(depth2);
  return plane;
}

// Clamped to the triangle's own range: the plane of a sliver seen edge-on leaves it within a pixel.
float sample_depth(DepthPlane plane, ivec2 offset) {
  precise float z = fma(plane.dx, float(offset.x) * (1.0 / 128.0), fma(plane.dy, float(offset.y) * (1.0 / 128.0), plane.centre));
  return clamp(z, plane.smallest, plane.largest);
}

#endif
