#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: PLAIN= LIT=-DLIT
// Aggregate G-buffer generation (AGAA paper, algorithm 2): a fragment adds its attributes, weighted by the samples it is seen
// in, to the aggregate of the first of them. Seen is a sample whose triangle is the fragment's: of coplanar duplicates one.
// LIT: its colours multiplied by the shadow of each of those samples as well (section 3.5.3).
// Reads: visibility (slot 0), the samples' aggregates; with LIT the shadow map. Reads and writes: the pixel's aggregates.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "include/visibility.glsl"
#ifdef LIT
#include "include/lights.glsl"
#endif
#include "techniques/agaa/aggregate.glsl"

layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
layout(set = 0, binding = SAMPLED(AGAA_SLOT_MEMBERSHIP)) uniform usampler2D aggregates;
#include "techniques/agaa/sums_access.glsl"

// World position of a sample that shows something.
vec3 sample_place(ivec2 pixel, uint s) {
  float depth = uintBitsToFloat(visible_depths(pixel, SAMPLES, s / 4u)[s & 3u]);
  return world_position(gl_FragCoord.xy + vec2(sample_offset(SAMPLES, s)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID)), depth);
}

// The mean fraction of the sun that arrives in the samples of `mask`.
float lit_fraction(ivec2 pixel, vec3 normal, uint mask) {
  float lit = 1.0;
#ifdef LIT
  float normal_light = clamp(-dot(normal, frame.sun_direction.xyz), 0.0, 1.0);
  lit = 0.0;
  for (uint left = mask; left != 0u; left &= left - 1u)
    lit += sun_visibility(sample_place(pixel, uint(findLSB(left))), normal, normal_light);
  lit /= float(int(bitCount(mask)));
#endif
  return lit;
}

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uvec4 own = uvec4(fragment_triangle());
  uint mask = 0u;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    bvec4 same = equal(visible_triangles(pixel, SAMPLES, quad), own);
    uvec4 bits = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), same);
    mask |= (bits.x | bits.y | bits.z | bits.w) << 4u * quad;
  }
  // lavapipe runs whole blocks of 4x4 pixels, beyond the image's borders too; what they write to attachments is dropped, but
  // this writes to a buffer.
  bool inside = all(lessThan(vec2(pixel), frame.viewport.xy));
  // A loop, so that groups of fragments that show nothing skip it.
  for (bool seen = mask != 0u && inside; seen; seen = false) {
    uint first = uint(findLSB(mask));
    uint aggregate = 0u;
    if (AGGREGATES > 1u) {
      uvec2 planes = texelFetch(aggregates, pixel, 0).xy;
      aggregate = (planes.x >> first & 1u) | (AGGREGATES > 2u ? (planes.y >> first & 1u) << 1 : 0u);
    }
    Surface surface = fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES));
    vec3 to_eye = agaa_option(AGAA_LEAN) ? normalize(frame.eye.xyz - sample_place(pixel, first)) : vec3(0.0, 0.0, 1.0);
    float lit = lit_fraction(pixel, surface.normal, mask);
    AggregateWords more = fragment_words(surface, to_eye, lit, mask, first, 1.0 / state.largest_emission);
    uint base = first_word(pixel, aggregate);
    for (uint i = 0u; i < kAggregateWords; ++i)
      state.sums.words[base + i] = sum_of_words(i, state.sums.words[base + i], more.word[i]);
  }
}
