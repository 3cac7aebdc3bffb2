// Coverage masks of up to 64 samples for a fragment: exact, or from a table of half-planes (Wang et al. 2015, section 3.1).
// Reads: the table. Needs SAMPLES and surface.glsl before it.
#ifndef SUBPIXEL_DCAA_COVERAGE_GLSL
#define SUBPIXEL_DCAA_COVERAGE_GLSL

#include "include/coverage.glsl"

// Directions of edges, and distances over a pixel, that the table has entries for (coverage_table.hpp).
layout(constant_id = DCAA_CONSTANT_TABLE_DIRECTIONS) const uint TABLE_DIRECTIONS = 256u;
layout(constant_id = DCAA_CONSTANT_TABLE_DISTANCES) const uint TABLE_DISTANCES = 128u;

layout(set = 0, binding = STORAGE(DCAA_SLOT_TABLE), scalar) readonly buffer CoverageTable { uvec2 half_planes[]; };

const uvec2 kWholePixel =
    uvec2(SAMPLES == 16u ? 0xffffu : 0xffffffffu, SAMPLES > 32u ? 0xffffffffu : 0u);

// The half-plane base + a x + b y >= 0 of samples (x, y) in 1/128 pixel.
uvec2 half_plane(float base, float a, float b) {
  // The direction as a point of the diamond |a| + |b| = 1, in which no sample is farther than 64 from the centre.
  float size = abs(a) + abs(b);
  float t = b / size, centre = (base + 0.5) / size;
  float turn = a >= 0.0 ? t + 1.0 : 3.0 - t;
  uint direction = round_to_even(turn * float(TABLE_DIRECTIONS / 4u)) & (TABLE_DIRECTIONS - 1u);
  float along = (centre + 64.0) * (float(TABLE_DISTANCES) / 128.0) + 0.5;
  uint distance = round_to_even(clamp(along, 0.0, float(TABLE_DISTANCES + 1u))) & 0xffffu;
  return half_planes[direction * (TABLE_DISTANCES + 2u) + distance];
}

uvec2 exact_coverage(PixelEdges edges) {
  return uvec2(coverage_mask(edges, SAMPLES, 0u, min(SAMPLES, 32u)),
               SAMPLES > 32u ? coverage_mask(edges, SAMPLES, 32u, 32u) : 0u);
}

uvec2 table_coverage(PixelEdges edges) {
  vec3 base = edges.base;
  for (bool go = edges.large; go; go = false) base = vec3(edges.large_base);
  return half_plane(base.x, edges.a.x, edges.b.x) & half_plane(base.y, edges.a.y, edges.b.y) &
         half_plane(base.z, edges.a.z, edges.b.z) & kWholePixel;
}

// Pixels wholly inside or outside need neither. Samples are up to 64 from the centre in both directions.
uvec2 fragment_coverage(PixelEdges edges) {
  vec3 reach = 64.0 * (abs(edges.a) + abs(edges.b));
  bool inside = all(greaterThanEqual(edges.base, reach)), outside = any(lessThan(edges.base, -reach));
  for (bool go = edges.large; go; go = false) {
    ivec3 large_reach = 64 * (abs(edges.large_a) + abs(edges.large_b));
    inside = all(greaterThanEqual(edges.large_base, large_reach));
    outside = any(lessThan(edges.large_base, -large_reach));
  }
  uvec2 mask = inside ? kWholePixel : uvec2(0u);
  for (bool go = !inside && !outside; go; go = false)
    mask = dcaa_option(DCAA_TABLE) ? table_coverage(edges) : exact_coverage(edges);
  return mask;
}

// Samples, as bits, whose offset plus 64, a number from 0 to 127, has bit 6, 5, 4 or 3 set. Written out, since drivers unroll
// loops up to a size only.
uvec2 offset_bits_x(uint bit) {
  if (SAMPLES == 16u) return uvec2(bit == 6u ? 0x62e9u : bit == 5u ? 0x654eu : bit == 4u ? 0x69b2u : 0xa0d7u, 0u);
  if (SAMPLES == 32u) return uvec2(bit == 6u ? 0xffff0000u : bit == 5u ? 0xff00ff00u : bit == 4u ? 0xf0f0f0f0u : 0xccccccccu, 0u);
  return bit == 6u ? uvec2(0u, 0xffffffffu) : uvec2(bit == 5u ? 0xffff0000u : bit == 4u ? 0xff00ff00u : 0xf0f0f0f0u);
}
uvec2 offset_bits_y(uint bit) {
  if (SAMPLES == 16u) return uvec2(bit == 6u ? 0x5965u : bit == 5u ? 0x693au : bit == 4u ? 0x45dcu : 0x42ebu, 0u);
  uint low = bit == 6u ? 0x96696996u : bit == 5u ? 0x3cc3c33cu : bit == 4u ? 0xf00f0ff0u : 0x00ffff00u;
  uint high = bit == 6u ? 0x69969669u : bit == 5u ? 0xc33c3cc3u : bit == 4u ? 0x0ff0f00fu : 0xff0000ffu;
  return uvec2(low, SAMPLES == 32u ? 0u : high);
}

// Mean position of the samples of `mask`, in pixels from the centre, to 1/32 pixel: from the counts of the samples that
// have each of the leading bits of their coordinates set.
vec2 mask_centroid(uvec2 mask) {
  vec2 sum = vec2(0.0);
  for (uint bit = SAMPLES > 16u ? 4u : 3u; bit < 7u; ++bit) {
    sum.x += float(1u << bit) * float(int(dcaa_count(mask & offset_bits_x(bit))));
    sum.y += float(1u << bit) * float(int(dcaa_count(mask & offset_bits_y(bit))));
  }
  float rest = SAMPLES > 16u ? 8.0 : 0.0;
  return (sum / max(float(int(dcaa_count(mask))), 1.0) + rest - 64.0) * (1.0 / 128.0);
}

#endif
