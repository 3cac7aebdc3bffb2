// A G-buffer sample as the techniques with samples of their own store it: the four words of packing.glsl, or two of them where
// they can hold all that varies in the scene.
//   x: albedo 3 x 8, then metallic 8, or roughness 8 in a scene without metal   y: normal
// The format of the image is that of stored_sample_format() of replay/techniques/deferred.hpp, which decides as narrow_samples()
// does.
// Reads: FEATURES, frame constants.
#ifndef SUBPIXEL_STORED_SAMPLE_GLSL
#define SUBPIXEL_STORED_SAMPLE_GLSL

#include "include/packing.glsl"

// Does one byte beside albedo and normal hold what a surface needs, its emission left out?
bool one_byte_more() { return !(has_feature(FEATURE_METAL) && has_feature(FEATURE_VARYING_ROUGHNESS)); }
bool narrow_samples() { return !has_feature(FEATURE_EMISSIVE) && one_byte_more(); }

// The two words of such a surface from those of packing.glsl, and back.
uvec2 narrowed(uvec4 packed) {
  // Without metal the metallic byte is 0.
  return uvec2(has_feature(FEATURE_METAL) ? packed.x : packed.x | packed.z << 24, packed.y);
}
uvec4 widened(uvec2 stored, uint emission) {
  const uint kFull = 255u << 8;  // occlusion, which no material has
  if (has_feature(FEATURE_METAL)) return uvec4(stored, rounded(clamp(frame.tone.y, 0.0, 1.0) * 255.0) | kFull, emission);
  return uvec4(stored.x & 0xffffffu, stored.y, stored.x >> 24 | kFull, emission);
}

// Two words as four components of 16 bits, which storage images of every device have; two of 32 they need not.
uvec4 halves_of_words(uvec2 words) { return uvec4(words.x & 0xffffu, words.x >> 16, words.y & 0xffffu, words.y >> 16); }
uvec2 words_of_halves(uvec4 halves) { return halves.xz | halves.yw << 16; }

uvec4 stored_sample(Surface s) {
  uvec4 packed = pack_surface(s);
  return narrow_samples() ? halves_of_words(narrowed(packed)) : packed;
}

// The four words of packing.glsl.
uvec4 packed_of_stored(uvec4 stored) { return narrow_samples() ? widened(words_of_halves(stored), 0u) : stored; }

// All but the position.
Surface surface_of_stored(uvec4 stored) { return unpack_surface(packed_of_stored(stored)); }

// The word of its normal.
uint normal_of_stored(uvec4 stored) { return narrow_samples() ? words_of_halves(stored).y : stored.y; }

#endif
