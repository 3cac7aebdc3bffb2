// The surface that a block holds: as words of packing.glsl, unpacked without its position, lit.
// Reads: the pool's words. Needs blocks.glsl.
#ifndef SUBPIXEL_LINKED_LIST_READ_SURFACE_GLSL
#define SUBPIXEL_LINKED_LIST_READ_SURFACE_GLSL

#include "deferred/stored_sample.glsl"
#include "include/coverage.glsl"

uvec4 packed_surface(LinkWords words, uint block) {
  uvec2 own = uvec2(words.word[block_word(block, 0u)], words.word[block_word(block, 1u)]);
  uint emission = has_feature(FEATURE_EMISSIVE) ? words.word[emission_word(block)] : 0u;
  if (one_byte_more()) return widened(own, emission);
  uint bytes = words.word[shared_word(block)] >> (8u * (block & 1u));
  return uvec4(own, (bytes & 255u) | (bytes & 0xff0000u) >> 8, emission);
}

Surface read_surface(LinkWords words, uint block) { return unpack_surface(packed_surface(words, block)); }

// Where sample s of the pixel is, by the depth buffer.
vec3 sample_position(ivec2 pixel, uint s) {
  vec2 offset = vec2(sample_offset(SAMPLES, s)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
  return world_position(vec2(frame_pixel(pixel)) + 0.5 + offset, uintBitsToFloat(visible_depths(pixel, SAMPLES, s / 4u)[s & 3u]));
}

// What a block's sample contributes to its pixel's sum.
vec3 lit_block(LinkWords words, uint block, ivec2 pixel, uint s) {
  Surface surface = read_surface(words, block);
  surface.position = sample_position(pixel, s);
  return resolvable(shade(surface, normalize(frame.eye.xyz - surface.position)));
}

// A lit value in the 64 bits of a block's albedo and normal, 21 bits a channel: floats without sign, 13 bits of mantissa.
uvec2 pack_lit(vec3 value) {
  uvec3 bits = (floatBitsToUint(max(value, 0.0)) + 512u) >> 10;
  return uvec2(bits.r | bits.g << 21, bits.g >> 11 | bits.b << 10);
}
vec3 unpack_lit(uvec2 packed) {
  uvec3 bits = uvec3(packed.x & 0x1fffffu, packed.x >> 21 | (packed.y & 0x3ffu) << 11, packed.y >> 10);
  return uintBitsToFloat(bits << 10);
}

#endif
