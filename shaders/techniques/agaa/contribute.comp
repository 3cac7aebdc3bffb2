#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: PLAIN= LIT=-DLIT
// What each visible fragment adds to an aggregate (AGAA paper, algorithm 2): its attributes, weighted by the samples it is seen in;
// they go to the aggregate of the first of those. Seen is a sample whose triangle is the fragment's: of coplanar duplicates one.
// LIT: its colours multiplied by the shadow of each of those samples as well (section 3.5.3).
// Reads: listed fragments, visibility (slot 0), the samples' aggregates; with LIT the shadow map.
// Writes: the fragments' words; in the place of the second word of masks, which 32 samples do not need, the aggregate.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
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
  vec2 centre = vec2(frame_pixel(pixel)) + 0.5;
  return world_position(centre + vec2(sample_offset(SAMPLES, s)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID)), depth);
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
  uint number;
  if (!listed_number(number)) return;
  ListAddresses to = lists;
  uvec4 fragment = to.fragments.fragment[number];
  ivec2 pixel = listed_pixel(fragment);
  uint mask = fragment.z, first = uint(findLSB(mask)), aggregate = 0u;
  if (AGGREGATES > 1u) {
    uvec2 planes = texelFetch(aggregates, pixel, 0).xy;
    aggregate = (planes.x >> first & 1u) | (AGGREGATES > 2u ? (planes.y >> first & 1u) << 1 : 0u);
  }
  load_fragment(fragment.x);
  Surface surface = fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES));
  vec3 to_eye = agaa_option(AGAA_LEAN) ? normalize(frame.eye.xyz - sample_place(pixel, first)) : vec3(0.0, 0.0, 1.0);
  float lit = lit_fraction(pixel, surface.normal, mask);
  AggregateWords words = fragment_words(surface, to_eye, lit, mask, first, 1.0 / state.largest_emission);
  to.fragments.fragment[number].w = aggregate;
  for (uint i = 0u; i < kAggregateWords; ++i) state.parts.words[number * kAggregateWords + i] = words.word[i];
}
