// The fragments of a pixel that need a dynamic block, told from its visibility: each by its leader, the lowest sample it shows in.
// Needs SAMPLES before it.
#ifndef SUBPIXEL_LINKED_LIST_LEADERS_GLSL
#define SUBPIXEL_LINKED_LIST_LEADERS_GLSL

#include "techniques/linked_list/blocks.glsl"

#ifndef WRITES_LEADERS
layout(set = 0, binding = SAMPLED(LINK_SLOT_LEADERS)) uniform usampler2D leaders_image;
#endif

struct PixelTriangles {
  uvec4 low, high;  // of samples 0 to 3 and 4 to 7
};

PixelTriangles pixel_triangles(ivec2 pixel) {
  uvec4 low = visible_triangles(pixel, SAMPLES, 0u);
  return PixelTriangles(low, SAMPLES > 4u ? visible_triangles(pixel, SAMPLES, 1u) : uvec4(SUBPIXEL_NO_TRIANGLE));
}

uint triangle_of(PixelTriangles t, uint s) { return s < 4u ? t.low[s] : t.high[s - 4u]; }

// In bits 0 to 7 the leaders of fragments without the pixel's own block; the samples each of them shows in, less one, in three
// bits from 8 + 3 times its number.
uint dynamic_leaders(PixelTriangles t) {
  uint leaders = 0u;
  bool mixed = false;
  for (uint s = 1u; s < SAMPLES; ++s) mixed = mixed || triangle_of(t, s) != t.low.x;
  // A loop, so that groups of pixels of one triangle each skip it.
  for (bool go = mixed; go; go = false) {
    uint covered = 0u;
    for (uint s = 0u; s < SAMPLES; ++s) covered |= triangle_of(t, s) != SUBPIXEL_NO_TRIANGLE ? 1u << s : 0u;
    uint own = first_sample(covered), own_triangle = t.low.x;
    for (uint s = 1u; s < SAMPLES; ++s) own_triangle = own == s ? triangle_of(t, s) : own_triangle;
    for (uint s = 0u; s < SAMPLES; ++s) {
      uint triangle = triangle_of(t, s);
      bool leads = triangle != SUBPIXEL_NO_TRIANGLE && triangle != own_triangle;
      for (uint i = 0u; i < s; ++i) leads = leads && triangle_of(t, i) != triangle;
      uint more = 0u;
      for (uint i = s + 1u; i < SAMPLES; ++i) more += triangle_of(t, i) == triangle ? 1u : 0u;
      leaders |= leads ? 1u << s | more << (8u + 3u * s) : 0u;
    }
  }
  return leaders;
}

uint leader_count(uint leaders, uint s) { return ((leaders >> (8u + 3u * s)) & 7u) + 1u; }

// Allocation goes level by level: fragments of most samples first, or all of them in one.
const uint kLevels = ALLOCATION == LINK_ALLOCATE_LARGEST ? SAMPLES : 1u;
uint leader_level(uint leaders, uint s) {
  return ALLOCATION == LINK_ALLOCATE_LARGEST ? SAMPLES - leader_count(leaders, s) : 0u;
}

uvec2 tile_counts() { return (uvec2(pool.width, pool.height) + LINK_TILE - 1u) / LINK_TILE; }

#endif
