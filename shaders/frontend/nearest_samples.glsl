// Nearest triangle of each sample: depth and triangle number of GROUP samples of the pattern, in primitive order, so that of
// equal depths the first submitted stays.
// Reads and writes: the attachments. GROUP 1: one of (depth bits, triangle); 2: one of two depth bits and two triangles; else
// GROUP / 4 of depth bits, then GROUP / 4 of triangles, four samples in each. Reversed depths are not negative, so their bits compare like the numbers.
// A shader that keeps more of a fragment which takes samples defines SAMPLES_TAKEN(pixel, edges, bits), with GROUP >= 4. Needs
// fragment.glsl before it.
#ifndef SUBPIXEL_NEAREST_SAMPLES_GLSL
#define SUBPIXEL_NEAREST_SAMPLES_GLSL

#if GROUP <= 2
layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in_state;
layout(location = 0) out uvec4 out_state;
#else
layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in_depth0;
layout(location = 0) out uvec4 out_depth0;
#if GROUP == 4
layout(input_attachment_index = 1, set = 0, binding = INPUT_ATTACHMENT(1)) uniform usubpassInput in_id0;
layout(location = 1) out uvec4 out_id0;
#elif GROUP == 8
layout(input_attachment_index = 1, set = 0, binding = INPUT_ATTACHMENT(1)) uniform usubpassInput in_depth1;
layout(input_attachment_index = 2, set = 0, binding = INPUT_ATTACHMENT(2)) uniform usubpassInput in_id0;
layout(input_attachment_index = 3, set = 0, binding = INPUT_ATTACHMENT(3)) uniform usubpassInput in_id1;
layout(location = 1) out uvec4 out_depth1;
layout(location = 2) out uvec4 out_id0;
layout(location = 3) out uvec4 out_id1;
#else
layout(input_attachment_index = 1, set = 0, binding = INPUT_ATTACHMENT(1)) uniform usubpassInput in_depth1;
layout(input_attachment_index = 2, set = 0, binding = INPUT_ATTACHMENT(2)) uniform usubpassInput in_depth2;
layout(input_attachment_index = 3, set = 0, binding = INPUT_ATTACHMENT(3)) uniform usubpassInput in_depth3;
layout(input_attachment_index = 4, set = 0, binding = INPUT_ATTACHMENT(4)) uniform usubpassInput in_id0;
layout(input_attachment_index = 5, set = 0, binding = INPUT_ATTACHMENT(5)) uniform usubpassInput in_id1;
layout(input_attachment_index = 6, set = 0, binding = INPUT_ATTACHMENT(6)) uniform usubpassInput in_id2;
layout(input_attachment_index = 7, set = 0, binding = INPUT_ATTACHMENT(7)) uniform usubpassInput in_id3;
layout(location = 1) out uvec4 out_depth1;
layout(location = 2) out uvec4 out_depth2;
layout(location = 3) out uvec4 out_depth3;
layout(location = 4) out uvec4 out_id0;
layout(location = 5) out uvec4 out_id1;
layout(location = 6) out uvec4 out_id2;
layout(location = 7) out uvec4 out_id3;
#endif
#endif

layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;  // which GROUP samples of the pattern
// The attachments hold small triangles already (small.comp), of which those submitted later lose equal depths.
layout(constant_id = FRONTEND_CONSTANT_AFTER_SMALL) const bool AFTER_SMALL = false;

uvec4 plane_depths(uint first, DepthPlane plane) {
  uvec4 z;
  for (uint i = 0u; i < 4u; ++i)
    z[i] = floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, SAMPLE_GROUP * GROUP + first + i)));
  return z;
}

bvec4 covered_four(uint mask, uint first) {
  return notEqual(uvec4(mask) & (uvec4(1u, 2u, 4u, 8u) << first), uvec4(0u));
}

// Which of four samples the fragment takes. Triangles of this pass come in order; a stored one that is small and whole may have
// been submitted later: its record is its slot, and a piece of a clipped triangle knows its own.
bvec4 taken(uvec4 z, uvec4 stored, uvec4 stored_triangle, uint mask, uint first) {
  bvec4 nearer = greaterThan(z, stored);
  if (AFTER_SMALL) {
    bvec4 earlier = lessThan(uvec4(fragment_slot()), stored_triangle);
    bvec4 whole = lessThan(stored_triangle, uvec4(push.triangle_slots));
    nearer = mix(nearer, earlier, mix(bvec4(false), equal(z, stored), whole));
  }
  return mix(bvec4(false), nearer, covered_four(mask, first));
}

#ifdef WITH_UV
uint bits_of(bvec4 take, uint first) {
  uvec4 bits = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), take);
  return (bits.x | bits.y | bits.z | bits.w) << first;
}

// Of the samples of take_samples() in groups of four.
#if GROUP == 16
#define TAKEN_BITS (bits_of(take0, 0u) | bits_of(take1, 4u) | bits_of(take2, 8u) | bits_of(take3, 12u))
#elif GROUP == 8
#define TAKEN_BITS (bits_of(take0, 0u) | bits_of(take1, 4u))
#else
#define TAKEN_BITS bits_of(take0, 0u)
#endif

// Of the samples that the fragment would take, those that alpha leaves: textures are read only where it is nearest so far.
uint alpha_leaves(uint mask, ivec2 pixel, PixelEdges edges) {
  uint left = mask;
#ifdef WITH_ATTRIBUTES
  // Draws of all materials.
  bool tested = has_feature(FEATURE_ALPHA_TEST) && (materials[push.material].flags.x & MATERIAL_ALPHA_TEST) != 0u;
#else
  const bool tested = true;
#endif
  for (bool go = tested && mask != 0u; go; go = false)
    left = alpha_mask(mask, SAMPLE_GROUP * GROUP, GROUP, pixel, shading_offset(edges, SAMPLES));
  return left;
}
bvec4 left_of(bvec4 take, uint left, uint first) { return mix(bvec4(false), take, covered_four(left, first)); }
#endif

// Does the fragment take any?
bool take_samples(ivec2 pixel) {
  PixelEdges edges = fragment_edges(pixel);
  uint mask = coverage_mask(edges, SAMPLES, SAMPLE_GROUP * GROUP, GROUP);
  bool changed = false;
  // Skipped, as a loop is, when no lane covers anything.
  for (bool go = mask != 0u; go; go = false) {
    DepthPlane plane = fragment_depth(pixel);
    uvec4 own = uvec4(fragment_triangle());
#if GROUP <= 2
    uvec4 state = subpassLoad(in_state);
#if GROUP == 1
    uvec4 old = uvec4(state.x, 0u, 0u, 0u), old_id = uvec4(state.y, 0u, 0u, 0u);
    uvec4 z = uvec4(floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, SAMPLE_GROUP))), 0u, 0u, 0u);
#else
    uvec4 old = uvec4(state.xy, 0u, 0u), old_id = uvec4(state.zw, 0u, 0u);
    uvec4 z = uvec4(floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, 0u))),
                    floatBitsToUint(sample_depth(plane, sample_offset(SAMPLES, 1u))), 0u, 0u);
#endif
    bvec4 take = taken(z, old, old_id, mask, 0u);
#ifdef WITH_UV
    take = left_of(take, alpha_leaves(bits_of(take, 0u), pixel, edges), 0u);
#endif
    changed = any(take);
    z = mix(old, z, take);
    own = mix(old_id, own, take);
    out_state = GROUP == 1 ? uvec4(z.x, own.x, 0u, 0u) : uvec4(z.xy, own.xy);
#else
    uvec4 old0 = subpassLoad(in_depth0), z0 = plane_depths(0u, plane);
    bvec4 take0 = taken(z0, old0, AFTER_SMALL ? subpassLoad(in_id0) : uvec4(0u), mask, 0u);
#if GROUP >= 8
    uvec4 old1 = subpassLoad(in_depth1), z1 = plane_depths(4u, plane);
    bvec4 take1 = taken(z1, old1, AFTER_SMALL ? subpassLoad(in_id1) : uvec4(0u), mask, 4u);
#endif
#if GROUP == 16
    uvec4 old2 = subpassLoad(in_depth2), z2 = plane_depths(8u, plane);
    bvec4 take2 = taken(z2, old2, AFTER_SMALL ? subpassLoad(in_id2) : uvec4(0u), mask, 8u);
    uvec4 old3 = subpassLoad(in_depth3), z3 = plane_depths(12u, plane);
    bvec4 take3 = taken(z3, old3, AFTER_SMALL ? subpassLoad(in_id3) : uvec4(0u), mask, 12u);
#endif
#ifdef WITH_UV
    uint left = alpha_leaves(TAKEN_BITS, pixel, edges);
    take0 = left_of(take0, left, 0u);
#if GROUP >= 8
    take1 = left_of(take1, left, 4u);
#endif
#if GROUP == 16
    take2 = left_of(take2, left, 8u);
    take3 = left_of(take3, left, 12u);
#endif
#endif
    changed = any(take0);
    out_depth0 = mix(old0, z0, take0);
#if GROUP >= 8
    changed = changed || any(take1);
    out_depth1 = mix(old1, z1, take1);
#endif
#if GROUP == 16
    changed = changed || any(take2) || any(take3);
    out_depth2 = mix(old2, z2, take2);
    out_depth3 = mix(old3, z3, take3);
#endif
    for (bool write = changed; write; write = false) {
#ifdef SAMPLES_TAKEN
      SAMPLES_TAKEN(pixel, edges, TAKEN_BITS);
#endif
      out_id0 = mix(subpassLoad(in_id0), own, take0);
#if GROUP >= 8
      out_id1 = mix(subpassLoad(in_id1), own, take1);
#endif
#if GROUP == 16
      out_id2 = mix(subpassLoad(in_id2), own, take2);
      out_id3 = mix(subpassLoad(in_id3), own, take3);
#endif
    }
#endif
  }
  return changed;
}

#endif
