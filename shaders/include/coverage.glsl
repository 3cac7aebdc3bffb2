// Exact coverage of the samples of one pixel by one snapped triangle, and its depth at a sample.
// Reads: nothing. Every pass that decides coverage or depth calls these functions, so the decisions agree bit for bit.
//
// With vertices on a 1/256 pixel grid, positive area and y down, the edge function of v0 -> v1 at a point,
//   E(x, y) = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0),
// is positive inside. Samples lie 2 k / 256 pixel from the centre (k an integer, |k| <= 64), so
//   E(sample) >= 0  <=>  floor(E(centre) / 2) + A kx + B ky >= 0,   A = -(y1 - y0), B = x1 - x0.
// How that stays exact depends on the size of the triangle's bounding box (RECORD_LARGE), the same for all its fragments:
// - up to SUBPIXEL_SMALL_PX: |A|, |B| < 2^14 and a hull's pixels are within 2^15 of every vertex, so the centre's value fits 32
//   bits. Clamped to 2^23 it can't change sign by the samples' terms, which are below 2^21, and float32 holds all sums.
// - larger: |A|, |B| < 2^22.6, the guard band and an image of 16384 pixels across. The centre's value is computed modulo 2^32
//   and, roughly, in floats, which are off by less than 2^23. Where those say less than 2^31 - 2^26 the former is exact; beyond,
//   their sign is right, and the samples' terms, below 2^29.6 together, can't change that of half of it.
#ifndef SUBPIXEL_COVERAGE_GLSL
#define SUBPIXEL_COVERAGE_GLSL

#include "frontend/frontend_types.h"
#include "frontend/sample_patterns.h"

struct PixelEdges {
  vec3 base, a, b;  // of a small triangle
  bool large;  // then of these
  ivec3 large_base, large_a, large_b;
};

// Top-left rule: a sample on an edge counts when the edge is a left edge (going up) or a top edge (level, going right).
bool edge_inclusive(ivec2 along) { return along.y < 0 || (along.y == 0 && along.x > 0); }

float small_edge_base(ivec2 from, ivec2 along, ivec2 point) {
  int value = along.x * (point.y - from.y) - along.y * (point.x - from.x) - (edge_inclusive(along) ? 0 : 1);
  return float(clamp(value >> 1, -8388608, 8388608));
}

int large_edge_base(ivec2 from, ivec2 along, ivec2 point) {
  ivec2 away = point - from;
  int value = along.x * away.y - along.y * away.x - (edge_inclusive(along) ? 0 : 1);
  float rough = float(along.x) * float(away.y) - float(along.y) * float(away.x);
  return abs(rough) < 2080374784.0 ? value >> 1 : (rough > 0.0 ? 1073741824 : -1073741824);
}

// The pixel of gl_FragCoord.xy, by adding 2^23, which leaves the integer in the low bits: lavapipe converts floats to integers one
// lane at a time.
ivec2 pixel_of(vec2 coordinate) {
  return ivec2(floatBitsToUint(coordinate - 0.5 + 8388608.0) & 0x7fffffu);
}

// `size_bits`: RECORD_LARGE of the triangle.
PixelEdges pixel_edges(ivec2 v0, ivec2 v1, ivec2 v2, ivec2 pixel, uint size_bits) {
  ivec2 point = pixel * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2;
  ivec2 d0 = v1 - v0, d1 = v2 - v1, d2 = v0 - v2;
  PixelEdges edges;
  edges.base = vec3(small_edge_base(v0, d0, point), small_edge_base(v1, d1, point), small_edge_base(v2, d2, point));
  edges.large_a = -ivec3(d0.y, d1.y, d2.y);
  edges.large_b = ivec3(d0.x, d1.x, d2.x);
  edges.a = vec3(edges.large_a);
  edges.b = vec3(edges.large_b);
  edges.large = (size_bits & RECORD_LARGE) != 0u;
  edges.large_base = ivec3(0);
  // All fragments of one triangle take the same way: loops skip what an `if` would compute under a mask.
  for (bool go = edges.large; go; go = false)
    edges.large_base = ivec3(large_edge_base(v0, d0, point), large_edge_base(v1, d1, point), large_edge_base(v2, d2, point));
  return edges;
}

bool small_covers(PixelEdges edges, ivec2 offset) {
  vec3 e = edges.base + edges.a * float(offset.x) + edges.b * float(offset.y);
  return (floatBitsToInt(e.x) | floatBitsToInt(e.y) | floatBitsToInt(e.z)) >= 0;
}

bool large_covers(PixelEdges edges, ivec2 offset) {
  ivec3 e = edges.large_base + edges.large_a * offset.x + edges.large_b * offset.y;
  return (e.x | e.y | e.z) >= 0;
}

bool covers(PixelEdges edges, ivec2 offset) {
  bool result = small_covers(edges, offset);
  for (bool go = edges.large; go; go = false) result = large_covers(edges, offset);
  return result;
}

// Mask of samples [first, first + count) of the n-sample pattern, sample first + i in bit i.
uint coverage_mask(PixelEdges edges, uint n, uint first, uint count) {
  uint mask = 0u;
  for (uint i = 0u; i < count; ++i) mask |= small_covers(edges, sample_offset(n, first + i)) ? 1u << i : 0u;
  for (bool go = edges.large; go; go = false) {
    mask = 0u;
    for (uint i = 0u; i < count; ++i) mask |= large_covers(edges, sample_offset(n, first + i)) ? 1u << i : 0u;
  }
  return mask;
}

// Of TriangleRecord::v2_ref.z. In a band its row may lie above the first.
ivec2 reference_pixel(uint packed_pixel) { return ivec2(packed_pixel & 0xffffu, int(packed_pixel) >> 16); }

struct DepthPlane {
  float centre, dx, dy, smallest, largest;  // at the pixel's centre; per pixel; over the triangle
};

// Depths are products and sums, each rounded, never fused: fma() leaves that to the implementation, and passes must agree.
// `depth`, `depth2`: as in TriangleRecord; `reference`: its reference pixel.
DepthPlane depth_plane(uvec4 depth, uint depth2, ivec2 reference, ivec2 pixel) {
  DepthPlane plane;
  plane.dx = uintBitsToFloat(depth.y);
  plane.dy = uintBitsToFloat(depth.z);
  vec2 away = vec2(pixel - reference);
  precise float centre = plane.dx * away.x + (plane.dy * away.y + uintBitsToFloat(depth.x));
  plane.centre = centre;
  plane.smallest = uintBitsToFloat(depth.w);
  plane.largest = uintBitsToFloat(depth2);
  return plane;
}

// Clamped to the triangle's own range: the plane of a sliver seen edge-on leaves it within a pixel.
float sample_depth(DepthPlane plane, ivec2 offset) {
  precise float z =
      plane.dx * (float(offset.x) * (1.0 / 128.0)) + (plane.dy * (float(offset.y) * (1.0 / 128.0)) + plane.centre);
  return clamp(z, plane.smallest, plane.largest);
}

#endif
