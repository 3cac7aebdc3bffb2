// A G-buffer sample as the techniques with samples of their own store it: the four words of packing.glsl, or two of them where
// they can hold all that varies in the scene.
//   x: albedo 3 x 8, then metallic 8, or roughness 8 in a scene without metal   y: normal
// The format of the image is gbuffer_image() of replay/techniques/deferred.hpp, which decides as narrow_samples() does.
// Reads: FEATURES, frame constants.
#ifndef SUBPIXEL_STORED_SAMPLE_GLSL
#define SUBPIXEL_STORED_SAMPLE_GLSL

#include "include/packing.glsl"

bool narrow_samples() {
  return !has_feature(FEATURE_EMISSIVE) && !(has_feature(FEATURE_METAL) && has_feature(FEATURE_VARYING_ROUGHNESS));
}

// Two words are in x and y.
uvec4 stored_sample(Surface s) {
  uvec4 packed = pack_surface(s);
  if (!narrow_samples()) return packed;
  // Without metal the metallic byte is 0.
  return uvec4(has_feature(FEATURE_METAL) ? packed.x : packed.x | packed.z << 24, packed.y, 0u, 0u);
}

// All but the position.
Surface surface_of_stored(uvec4 stored) {
  const uint kFull = 255u << 8;  // occlusion, which no material has
  if (narrow_samples() && has_feature(FEATURE_METAL)) stored.zw = uvec2(rounded(clamp(frame.tone.y, 0.0, 1.0) * 255.0) | kFull, 0u);
  if (narrow_samples() && !has_feature(FEATURE_METAL)) stored = uvec4(stored.x & 0xffffffu, stored.y, stored.x >> 24 | kFull, 0u);
  return unpack_surface(stored);
}

#endif
