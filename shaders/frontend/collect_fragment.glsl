// What the passes that collect fragments do with one: COUNT counts it for its pixel, STORE puts it into both lists.
// Needs fragment_lists.glsl, coverage.glsl, SAMPLES and `lists`, a ListAddresses, before it.
#ifndef SUBPIXEL_COLLECT_FRAGMENT_GLSL
#define SUBPIXEL_COLLECT_FRAGMENT_GLSL

// Masks of up to 32 samples are made here, and pixels without a sample left out; or later, by passes whose vectors are full, and
// the lists hold every pixel that the edges reach.
layout(constant_id = FRONTEND_CONSTANT_WITH_MASKS) const bool WITH_MASKS = true;

uint listed_mask(PixelEdges edges) {
  if (WITH_MASKS) return coverage_mask(edges, SAMPLES, 0u, SAMPLES);
  // Samples are up to 64 steps from the centre in both directions.
  vec3 reach = 64.0 * (abs(edges.a) + abs(edges.b));
  bool outside = any(lessThan(edges.base, -reach));
  for (bool go = edges.large; go; go = false) {
    ivec3 large_reach = 64 * (abs(edges.large_a) + abs(edges.large_b));
    outside = any(lessThan(edges.large_base, -large_reach));
  }
  return outside ? 0u : 0xffffffffu;
}

void collect_count(ListAddresses to, ivec2 pixel, uint width) {
  atomicAdd(to.ends.end[uint(pixel.y) * width + uint(pixel.x)], 1u);
}

// `number`: the fragment's place by triangle.
void collect_store(ListAddresses to, uint number, uint record, ivec2 pixel, uint mask, uint width) {
  to.fragments.fragment[number] = uvec4(record, uint(pixel.x) | uint(pixel.y) << 16, WITH_MASKS ? mask : 0u, 0u);
  uint place = atomicAdd(to.ends.end[uint(pixel.y) * width + uint(pixel.x)], 1u);
  to.numbers.number[place] = number;
}

#endif
