// An aggregate's words, what a fragment adds to them, and what shading reads out of them.
// Fixed point, as figure 7 of the AGAA paper lays out 16 bytes:
//   word 0: normal x, y, 16 bits each                     word 1: normal z 16, luma of the specular colour 16
//   word 2: diffuse colour, 3 x 10 bits                   word 3: chroma of the specular colour 2 x 8, roughness 8, mask 8
// Without metal nothing but roughness and mask is left of word 3, and they lie in the upper half of word 1;
// then the mask, where it has more than 8 bits; the emission, 3 words; the normals' second moments, 6 x 16 bits, or of their
// slopes the first moments, 2 x 16 bits, and the second, 3 words; diffuse and specular colour where the sun reaches, each as above.
// The paper's 8 bits of emission are one scalar; ours has a colour and no upper bound, so those bits hold the roughness instead.
// Every field is a sum of values in [0, 1] weighted by samples / n. Its full scale leaves room for the sum's rounding, so that no
// field carries into the next, and is a multiple of 2 n, so that 0 and 1/2 (a grey's chroma, a normal's 0) stay exact.
// Float: the same sums in 32-bit floats, a word each.
// The including shader defines SAMPLES. Reads and writes: nothing.
#ifndef SUBPIXEL_AGAA_AGGREGATE_GLSL
#define SUBPIXEL_AGAA_AGGREGATE_GLSL

#include "include/brdf.glsl"
#include "include/frame.glsl"
#include "include/rounding.glsl"
#include "techniques/agaa/agaa_interface.h"

layout(constant_id = AGAA_CONSTANT_OPTIONS) const uint AGAA_OPTIONS = 0u;

bool agaa_option(uint option) { return (AGAA_OPTIONS & option) != 0u; }

#define AGAA_MAX_WORDS 26
const uint kFloatStorage = AGAA_OPTIONS & AGAA_FLOAT;
const uint kMetal = BIT_OF(FEATURES, FEATURE_METAL);
const uint kByteWord = kMetal != 0u ? 3u : 1u;  // bits 16 to 23 are the roughness, 24 to 31 a mask of 8 samples
const uint kWideMask = SAMPLES > 8u ? 1u : 0u;
const uint kMaskWord = kFloatStorage != 0u ? 10u : (kWideMask != 0u ? 3u + kMetal : kByteWord);
const uint kEmissionWord = AGAA_EMISSION_WORD(SAMPLES, FEATURES, AGAA_OPTIONS);
const uint kMomentsWord = AGAA_MOMENTS_WORD(SAMPLES, FEATURES, AGAA_OPTIONS);
const uint kLitWord = AGAA_LIT_WORD(SAMPLES, FEATURES, AGAA_OPTIONS);
const uint kAggregateWords = AGAA_WORDS(SAMPLES, FEATURES, AGAA_OPTIONS);

struct Aggregate {
  vec3 normal;        // mean, not longer than 1
  vec3 diffuse;       // mean colours
  vec3 reflectance;   // at normal incidence
  float roughness;    // perceptual; mean
  vec3 emissive;
  vec3 moments, mixed_moments;  // E[xx, yy, zz], E[xy, xz, yz] of the normals
  vec2 slope;                   // E[x, y] and
  vec3 slope_moments;           // E[xx, xy, yy] of the normals' slopes in slope_frame()
  vec3 lit_diffuse, lit_reflectance;  // mean colours times the lit fraction of each sample
  uint mask;
};

// Highlights' exponent for a GGX alpha: step 1 of section 3.5.2, and its inverse, step 4.
float exponent_of(float alpha_squared) { return 2.0 / alpha_squared - 2.0; }
float alpha_squared_of(float exponent) { return 2.0 / (exponent + 2.0); }
float alpha_squared_of_roughness(float roughness) {
  float alpha = clamp(roughness, kRoughnessFloor, 1.0);
  alpha *= alpha;
  return alpha * alpha;
}

// A normal as long as the mean of a lobe of this roughness around it: Toksvig's relation, exponent = length / (1 - length).
// Floored, so that the roughest keep a direction.
float length_of_roughness(float roughness) {
  float exponent = max(exponent_of(alpha_squared_of_roughness(roughness)), 0.25);
  return exponent / (exponent + 1.0);
}

// Unit vectors at right angles to the unit vector `axis` and to each other. Duff et al. 2017, "Building an orthonormal basis,
// revisited".
void tangents_of(vec3 axis, out vec3 tangent, out vec3 bitangent) {
  float side = axis.z < 0.0 ? -1.0 : 1.0;
  float p = -1.0 / (side + axis.z), q = axis.x * axis.y * p;
  tangent = vec3(1.0 + side * axis.x * axis.x * p, side * q, -side * axis.x);
  bitangent = vec3(q, side + axis.y * axis.y * p, -axis.y);
}

// LEAN mapping (Olano and Baker 2010; AGAA paper, section 3.4.1) keeps moments of slopes, which add up in one frame only: here
// that of the direction to the eye, which visible faces are turned to. Columns are its tangents and itself, world space. Built in
// view space, where no direction to the eye is near the tangents' jump.
mat3 slope_frame(vec3 to_eye) {
  mat3 view = mat3(frame.view);
  vec3 axis = view * to_eye, tangent, bitangent;
  tangents_of(axis, tangent, bitangent);
  return transpose(view) * mat3(tangent, bitangent, axis);
}

// Slopes are shortened to this, 76 degrees from the eye; interpolated normals can be turned away from it.
const float kLargestSlope = 4.0;

vec2 slope_of(vec3 normal, mat3 axes) {
  vec3 n = normal * axes;
  return n.xy / max(max(n.z, length(n.xy) / kLargestSlope), 1e-6);
}

float fixed_scale(uint bits) {
  return float(((1u << bits) - 1u - SAMPLES) / (2u * SAMPLES) * (2u * SAMPLES));
}
// Emission has the range of a float's integers.
float emission_scale() { return fixed_scale(22u); }

// What one fragment adds to a field: `value` in [0, 1], `weight` its samples / n. Fragments of one pixel round at different
// thresholds, `dither`, so that rounding adds up to about nothing instead of to a bias.
uint fixed_field(float value, uint bits, float weight, float dither) {
  float x = clamp(value, 0.0, 1.0) * weight * fixed_scale(bits);
  return round_to_even(max(x + (dither - 0.5), 0.0)) & 0x3fffffu;
}

// Different for every first sample, even over the pixel; in (0, 1).
float fragment_dither(uint first_sample) {
  return (float(int((first_sample * 5u + 3u) % SAMPLES)) + 0.5) / float(SAMPLES);
}

float luma(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }
// ITU-R BT.709: both in [-1/2, 1/2] for colours in [0, 1].
vec2 chroma(vec3 c, float y) { return vec2((c.b - y) / 1.8556, (c.r - y) / 1.5748); }
vec3 colour_of(float y, vec2 cbcr) {
  float r = y + 1.5748 * cbcr.y, b = y + 1.8556 * cbcr.x;
  return clamp(vec3(r, (y - 0.2126 * r - 0.0722 * b) / 0.7152, b), 0.0, 1.0);
}

struct AggregateWords {
  uint word[AGAA_MAX_WORDS];
};

// What a fragment of surface `s`, seen in the samples of `mask`, adds. `to_eye`: unit vector; `lit`: the fraction of the sun that
// arrives in those samples; `inverse_emission`: 1 / the largest emission of the scene.
AggregateWords fragment_words(Surface s, vec3 to_eye, float lit, uint mask, uint first_sample, float inverse_emission) {
  float weight = float(int(bitCount(mask))) / float(SAMPLES);
  vec3 albedo = clamp(s.albedo, 0.0, 1.0);
  float metallic = has_feature(FEATURE_METAL) ? clamp(s.metallic, 0.0, 1.0) : 0.0;
  vec3 diffuse = albedo * (1.0 - metallic);
  vec3 reflectance = mix(vec3(kDielectricReflectance), albedo, metallic);
  vec3 n = s.normal;
  vec3 moments = n * n, mixed = n.xxy * n.yzz;
  vec2 slope = agaa_option(AGAA_LEAN) ? slope_of(n, slope_frame(to_eye)) : vec2(0.0);
  vec3 slope_moments = slope.xxy * slope.xyy;
  if (agaa_option(AGAA_ROUGHNESS_IN_NORMAL)) n *= length_of_roughness(s.roughness);
  AggregateWords words;
  for (uint i = 0u; i < AGAA_MAX_WORDS; ++i) words.word[i] = 0u;
  if (agaa_option(AGAA_FLOAT)) {
    for (uint c = 0u; c < 3u; ++c) {
      words.word[c] = floatBitsToUint(n[c] * weight);
      words.word[3u + c] = floatBitsToUint(diffuse[c] * weight);
      words.word[6u + c] = floatBitsToUint(reflectance[c] * weight);
      if (has_feature(FEATURE_EMISSIVE)) words.word[kEmissionWord + c] = floatBitsToUint(s.emissive[c] * weight);
      if (agaa_option(AGAA_SGGX)) {
        words.word[kMomentsWord + c] = floatBitsToUint(moments[c] * weight);
        words.word[kMomentsWord + 3u + c] = floatBitsToUint(mixed[c] * weight);
      }
      if (agaa_option(AGAA_LEAN)) words.word[kMomentsWord + 2u + c] = floatBitsToUint(slope_moments[c] * weight);
      if (agaa_option(AGAA_LIT)) {
        words.word[kLitWord + c] = floatBitsToUint(diffuse[c] * (lit * weight));
        words.word[kLitWord + 3u + c] = floatBitsToUint(reflectance[c] * (lit * weight));
      }
    }
    if (agaa_option(AGAA_LEAN)) {
      words.word[kMomentsWord] = floatBitsToUint(slope.x * weight);
      words.word[kMomentsWord + 1u] = floatBitsToUint(slope.y * weight);
    }
    words.word[9] = floatBitsToUint(s.roughness * weight);
    words.word[kMaskWord] = mask;
    return words;
  }
  float dither = fragment_dither(first_sample);
  uvec3 normal16, diffuse10;
  for (uint c = 0u; c < 3u; ++c) {
    normal16[c] = fixed_field(n[c] * 0.5 + 0.5, 16u, weight, dither);
    diffuse10[c] = fixed_field(diffuse[c], 10u, weight, dither);
    if (has_feature(FEATURE_EMISSIVE))
      words.word[kEmissionWord + c] = fixed_field(s.emissive[c] * inverse_emission, 22u, weight, dither);
  }
  words.word[0] = normal16.x | normal16.y << 16;
  words.word[1] = normal16.z;
  words.word[2] = diffuse10.x | diffuse10.y << 10 | diffuse10.z << 20;
  if (has_feature(FEATURE_METAL)) {
    float y = luma(reflectance);
    vec2 cbcr = chroma(reflectance, y) + 0.5;
    words.word[1] |= fixed_field(y, 16u, weight, dither) << 16;
    words.word[3] = fixed_field(cbcr.x, 8u, weight, dither) | fixed_field(cbcr.y, 8u, weight, dither) << 8;
  }
  if (has_feature(FEATURE_VARYING_ROUGHNESS)) words.word[kByteWord] |= fixed_field(s.roughness, 8u, weight, dither) << 16;
  words.word[kMaskWord] |= kWideMask != 0u ? mask : mask << 24;
  if (agaa_option(AGAA_SGGX)) {
    for (uint c = 0u; c < 3u; ++c)
      words.word[kMomentsWord + c] = fixed_field(moments[c], 16u, weight, dither) |
                                     fixed_field(mixed[c] * 0.5 + 0.5, 16u, weight, dither) << 16;
  }
  if (agaa_option(AGAA_LEAN)) {
    vec2 part = slope * (0.5 / kLargestSlope) + 0.5;
    words.word[kMomentsWord] =
        fixed_field(part.x, 16u, weight, dither) | fixed_field(part.y, 16u, weight, dither) << 16;
    vec3 square = slope_moments * (1.0 / (kLargestSlope * kLargestSlope));
    square.y = square.y * 0.5 + 0.5;
    for (uint c = 0u; c < 3u; ++c) words.word[kMomentsWord + 1u + c] = fixed_field(square[c], 22u, weight, dither);
  }
  if (agaa_option(AGAA_LIT)) {
    vec3 lit_diffuse = diffuse * lit;
    float y = luma(reflectance * lit);
    vec2 cbcr = chroma(reflectance * lit, y) + 0.5;
    words.word[kLitWord] = fixed_field(lit_diffuse.x, 10u, weight, dither) |
                           fixed_field(lit_diffuse.y, 10u, weight, dither) << 10 |
                           fixed_field(lit_diffuse.z, 10u, weight, dither) << 20;
    words.word[kLitWord + 1u] = fixed_field(y, 16u, weight, dither) << 16;
    if (has_feature(FEATURE_METAL))
      words.word[kLitWord + 1u] |=
          fixed_field(cbcr.x, 8u, weight, dither) | fixed_field(cbcr.y, 8u, weight, dither) << 8;
  }
  return words;
}

// Word `i` after adding `more`. The masks of one aggregate's fragments have no sample in common.
uint sum_of_words(uint i, uint before, uint more) {
  if (!agaa_option(AGAA_FLOAT) || i == kMaskWord) return before + more;
  return floatBitsToUint(uintBitsToFloat(before) + uintBitsToFloat(more));
}

uint aggregate_mask(uint mask_word) { return !agaa_option(AGAA_FLOAT) && SAMPLES <= 8u ? mask_word >> 24 : mask_word; }

// The means over an aggregate's samples. `roughness`: that of the scene, where it doesn't vary.
Aggregate aggregate_of_words(AggregateWords words, float roughness, float largest_emission) {
  Aggregate a;
  a.mask = aggregate_mask(words.word[kMaskWord]);
  float each = float(SAMPLES) / float(max(int(bitCount(a.mask)), 1));
  a.emissive = vec3(0.0);
  a.moments = vec3(1.0 / 3.0);
  a.mixed_moments = vec3(0.0);
  a.slope = vec2(0.0);
  a.slope_moments = vec3(0.0);
  a.roughness = roughness;
  if (agaa_option(AGAA_FLOAT)) {
    for (uint c = 0u; c < 3u; ++c) {
      a.normal[c] = uintBitsToFloat(words.word[c]) * each;
      a.diffuse[c] = uintBitsToFloat(words.word[3u + c]) * each;
      a.reflectance[c] = uintBitsToFloat(words.word[6u + c]) * each;
      if (has_feature(FEATURE_EMISSIVE)) a.emissive[c] = uintBitsToFloat(words.word[kEmissionWord + c]) * each;
      if (agaa_option(AGAA_SGGX)) {
        a.moments[c] = uintBitsToFloat(words.word[kMomentsWord + c]) * each;
        a.mixed_moments[c] = uintBitsToFloat(words.word[kMomentsWord + 3u + c]) * each;
      }
      if (agaa_option(AGAA_LEAN)) a.slope_moments[c] = uintBitsToFloat(words.word[kMomentsWord + 2u + c]) * each;
      if (agaa_option(AGAA_LIT)) {
        a.lit_diffuse[c] = uintBitsToFloat(words.word[kLitWord + c]) * each;
        a.lit_reflectance[c] = uintBitsToFloat(words.word[kLitWord + 3u + c]) * each;
      }
    }
    if (agaa_option(AGAA_LEAN))
      a.slope = uintBitsToFloat(uvec2(words.word[kMomentsWord], words.word[kMomentsWord + 1u])) * each;
    a.roughness = uintBitsToFloat(words.word[9]) * each;
  } else {
    float unit16 = each / fixed_scale(16u), unit10 = each / fixed_scale(10u), unit8 = each / fixed_scale(8u);
    uvec3 normal = uvec3(words.word[0] & 0xffffu, words.word[0] >> 16, words.word[1] & 0xffffu);
    a.normal = vec3(ivec3(normal)) * (2.0 * unit16) - 1.0;
    uvec3 diffuse = uvec3(words.word[2], words.word[2] >> 10, words.word[2] >> 20) & 0x3ffu;
    a.diffuse = min(vec3(ivec3(diffuse)) * unit10, 1.0);
    a.reflectance = vec3(kDielectricReflectance);
    if (has_feature(FEATURE_METAL)) {
      vec2 cbcr = vec2(ivec2(words.word[3] & 255u, words.word[3] >> 8 & 255u)) * unit8 - 0.5;
      float y = float(int(words.word[1] >> 16)) * unit16;
      a.reflectance = colour_of(y, cbcr);
      // Black has no chroma, however that was rounded: unlit surfaces reflect nothing at all.
      if (has_feature(FEATURE_UNLIT)) a.reflectance = y > 0.0 ? a.reflectance : vec3(0.0);
    }
    if (has_feature(FEATURE_VARYING_ROUGHNESS)) a.roughness = float(int(words.word[kByteWord] >> 16 & 255u)) * unit8;
    for (uint c = 0u; c < 3u; ++c) {
      if (has_feature(FEATURE_EMISSIVE))
        a.emissive[c] = float(int(words.word[kEmissionWord + c])) * (each / emission_scale()) * largest_emission;
      if (agaa_option(AGAA_SGGX)) {
        uint word = words.word[kMomentsWord + c];
        a.moments[c] = float(int(word & 0xffffu)) * unit16;
        a.mixed_moments[c] = float(int(word >> 16)) * (2.0 * unit16) - 1.0;
      }
      if (agaa_option(AGAA_LEAN))
        a.slope_moments[c] = float(int(words.word[kMomentsWord + 1u + c])) * (each / fixed_scale(22u));
    }
    if (agaa_option(AGAA_LEAN)) {
      uint word = words.word[kMomentsWord];
      a.slope = (vec2(ivec2(word & 0xffffu, word >> 16)) * (2.0 * unit16) - 1.0) * kLargestSlope;
      a.slope_moments.y = a.slope_moments.y * 2.0 - 1.0;
      a.slope_moments *= kLargestSlope * kLargestSlope;
    }
    if (agaa_option(AGAA_LIT)) {
      uint word = words.word[kLitWord], specular = words.word[kLitWord + 1u];
      a.lit_diffuse = min(vec3(ivec3(uvec3(word, word >> 10, word >> 20) & 0x3ffu)) * unit10, 1.0);
      float y = float(int(specular >> 16)) * unit16;
      vec2 cbcr = vec2(ivec2(specular & 255u, specular >> 8 & 255u)) * unit8 - 0.5;
      a.lit_reflectance = y > 0.0 ? (has_feature(FEATURE_METAL) ? colour_of(y, cbcr) : vec3(y)) : vec3(0.0);
    }
  }
  float square = dot(a.normal, a.normal);
  a.normal *= square > 1.0 ? inversesqrt(square) : 1.0;
  return a;
}

#endif
