// Weighted means of what two surfaces store, for techniques that merge them. Every operation is given its order, so
// that merged surfaces are the same bits everywhere.
// Reads: FEATURES.
#ifndef SUBPIXEL_BLENDING_GLSL
#define SUBPIXEL_BLENDING_GLSL

#include "include/packing.glsl"

// Of two sides by their samples.
struct BlendWeights {
  float a, b;
};
BlendWeights weights_by_samples(uint samples_a, uint samples_b) {
  float count_a = float(int(samples_a)), count_b = float(int(samples_b));
  precise float weight_a = count_a / (count_a + count_b);
  precise float weight_b = count_b / (count_a + count_b);
  return BlendWeights(weight_a, weight_b);
}

float blend(float a, float b, BlendWeights w) {
  precise float mean = a * w.a + b * w.b;
  return mean;
}
vec2 blend(vec2 a, vec2 b, BlendWeights w) {
  precise vec2 mean = a * w.a + b * w.b;
  return mean;
}
vec3 blend(vec3 a, vec3 b, BlendWeights w) {
  precise vec3 mean = a * w.a + b * w.b;
  return mean;
}

float byte_of(uint word, uint shift) { return float(int((word >> shift) & 255u)); }

// The byte at `shift` of both words, at `shift` of the result.
uint blend_byte(uint a, uint b, uint shift, BlendWeights w) {
  return (round_to_even(blend(byte_of(a, shift), byte_of(b, shift), w)) & 255u) << shift;
}

// Both halves of a word.
uint blend_halves(uint a, uint b, BlendWeights w) {
  uint low = round_to_even(blend(float(int(a & 0xffffu)), float(int(b & 0xffffu)), w)) & 0xffffu;
  uint high = round_to_even(blend(float(int(a >> 16)), float(int(b >> 16)), w)) & 0xffffu;
  return low | high << 16;
}

// Albedo and metallic as packing.glsl has them. Albedo is stored as square roots; its mean is one of linear values.
uint blend_albedo(uint a, uint b, BlendWeights w) {
  uint result = has_feature(FEATURE_METAL) ? blend_byte(a, b, 24u, w) : 0u;
  for (uint shift = 0u; shift < 24u; shift += 8u) {
    float root_a = byte_of(a, shift), root_b = byte_of(b, shift);
    precise float mean = root_a * root_a * w.a + root_b * root_b * w.b;
    result |= (round_to_even(sqrt(mean)) & 255u) << shift;
  }
  return result;
}

// Shared exponents; 0 where nothing emits.
uint blend_emission(uint a, uint b, BlendWeights w) {
  uint result = 0u;
  if (has_feature(FEATURE_EMISSIVE))
    result = pack_shared_exponent(blend(unpack_shared_exponent(a), unpack_shared_exponent(b), w));
  return result;
}

#endif
