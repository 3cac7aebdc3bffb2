// Coverage masks of up to 64 samples for a fragment: exact, or from a table of half-planes (Wang et al. 2015, section 3.1).
// Reads: the table, storage slot 1. Needs SAMPLES and surface.glsl before it.
#ifndef SUBPIXEL_DCAA_COVERAGE_GLSL
#define SUBPIXEL_DCAA_COVERAGE_GLSL

#include "include/coverage.glsl"

// Directions of edges, and distances over a pixel, that the table has entries for (coverage_table.hpp).
layout(constant_id = 15) const uint TABLE_DIRECTIONS = 256u;
layout(constant_id = 16) const uint TABLE_DISTANCES = 128u;

layout(set = 0, binding = 2, scalar) readonly buffer CoverageTable { uvec2 half_planes[]; };

const uvec2 kWholePixel =
    uvec2(SAMPLES == 16u ? 0xffffu : 0xffffffffu, SAMPLES > 32u ? 0xffffffffu : 0u);

// The half-plane base + a x + b y >= 0 of samples (x, y) in 1/128 pixel.
uvec2 half_plane(float base, float a, float b) {
  // The direction as a point of the diamond |a| + |b| = 1, in which no sample is farther than 64 from the centre.
  float size = abs(a) + abs(b);
  float t = b / size, centre = (base + 0.5) / size;
  float turn = a >= 0.0 ? t + 1.0 : 3.0 - t;
  uint direction = dcaa_round(turn * float(TABLE_DIRECTIONS / 4u)) & (TABLE_DIRECTIONS - 1u);
  float along = (centre + 64.0) * (float(TABLE_DISTANCES) / 128.0) + 0.5;
  uint distance = dcaa_round(clamp(along, 0.0, float(TABLE_DISTANCES + 1u))) & 0xffffu;
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

// Samples, as bits, whose offset has `bit` set in the given axis (offsets as numbers from 0 to 127).
uvec2 offset_bits(uint axis, uint bit) {
  uvec2 samples = uvec2(0u);
  for (uint i = 0u; i < SAMPLES; ++i) {
    uint at = uint(sample_offset(SAMPLES, i)[axis] + 64);
    if (((at >> bit) & 1u) != 0u) samples[i >> 5] |= 1u << (i & 31u);
  }
  return samples;
}

// Mean position of the samples of `mask`, in pixels from the centre, to 1/32 pixel: from the counts of the samples that
// have each of the leading bits of their coordinates set.
vec2 mask_centroid(uvec2 mask) {
  vec2 sum = vec2(0.0);
  for (uint bit = SAMPLES > 16u ? 4u : 3u; bit < 7u; ++bit) {
    sum.x += float(1u << bit) * float(int(dcaa_count(mask & offset_bits(0u, bit))));
    sum.y += float(1u << bit) * float(int(dcaa_count(mask & offset_bits(1u, bit))));
  }
  float rest = SAMPLES > 16u ? 8.0 : 0.0;
  return (sum / max(float(int(dcaa_count(mask))), 1.0) + rest - 64.0) * (1.0 / 128.0);
}

#endif
