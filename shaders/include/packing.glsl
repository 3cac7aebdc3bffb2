// The 16-byte G-buffer sample that all techniques store surfaces in.
//   x: albedo, 3 x 8 bits with square-root encoding, metallic 8   y: normal, octahedral 2 x 16
//   z: roughness 8, occlusion 8, 16 unused                        w: emission, shared exponent 9+9+9+5
// Octahedral normals: Cigolle et al. 2014. Shared exponent: EXT_texture_shared_exponent.
// Reads: FEATURES; parts that no material of the scene needs are constants and cost nothing.
#ifndef SUBPIXEL_PACKING_GLSL
#define SUBPIXEL_PACKING_GLSL

#include "include/frame.glsl"
#include "include/rounding.glsl"
#include "include/surface.glsl"

// Rounds as packUnorm4x8() does.
uint rounded(float x) { return round_to_even(x) & 0xffffu; }

uint pack_unorm4x8(vec4 v) {
  v = clamp(v, 0.0, 1.0) * 255.0;
  return rounded(v.x) | rounded(v.y) << 8 | rounded(v.z) << 16 | rounded(v.w) << 24;
}

uint pack_snorm2x16(vec2 v) {
  v = clamp(v, -1.0, 1.0) * 32767.0;
  return rounded(v.x) | rounded(v.y) << 16;
}

uint pack_normal(vec3 n) {
  float l1 = abs(n.x) + abs(n.y) + abs(n.z);
  vec2 p = n.xy / max(l1, 1e-20);
  vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  return pack_snorm2x16(n.z < 0.0 ? folded : p);
}

vec3 unpack_normal(uint packed) {
  vec2 p = unpackSnorm2x16(packed);
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float t = max(-n.z, 0.0);
  n.xy += vec2(n.x >= 0.0 ? -t : t, n.y >= 0.0 ? -t : t);
  return n * inversesqrt(max(dot(n, n), 1e-20));
}

uint pack_shared_exponent(vec3 radiance) {
  vec3 c = clamp(radiance, 0.0, 65408.0);
  float largest = max(max(c.r, c.g), max(c.b, 1e-8));
  int exponent = max(-16, int(floor(log2(largest)))) + 16;
  float scale = exp2(float(9 + 15 - exponent));
  if (uint(largest * scale + 0.5) == 512u) {
    ++exponent;
    scale *= 0.5;
  }
  return rounded(floor(c.r * scale + 0.5)) | rounded(floor(c.g * scale + 0.5)) << 9 |
         rounded(floor(c.b * scale + 0.5)) << 18 | uint(exponent) << 27;
}

vec3 unpack_shared_exponent(uint packed) {
  float scale = exp2(float(int(packed >> 27) - 24));
  return vec3(packed & 511u, (packed >> 9) & 511u, (packed >> 18) & 511u) * scale;
}

uvec4 pack_surface(Surface s) {
  uvec4 packed;
  packed.x = pack_unorm4x8(vec4(sqrt(clamp(s.albedo, 0.0, 1.0)), has_feature(FEATURE_METAL) ? s.metallic : 0.0));
  packed.y = pack_normal(s.normal);
  packed.z = pack_unorm4x8(vec4(s.roughness, s.occlusion, 0.0, 0.0));
  packed.w = 0u;
  // A loop, so that groups of pixels that don't emit skip it.
  for (bool emits = has_feature(FEATURE_EMISSIVE) && any(greaterThan(s.emissive, vec3(0.0))); emits; emits = false)
    packed.w = pack_shared_exponent(s.emissive);
  return packed;
}

// All but the position.
Surface unpack_surface(uvec4 packed) {
  Surface s;
  vec4 albedo_metallic = unpackUnorm4x8(packed.x);
  s.albedo = albedo_metallic.rgb * albedo_metallic.rgb;
  s.metallic = has_feature(FEATURE_METAL) ? albedo_metallic.a : 0.0;
  s.normal = unpack_normal(packed.y);
  vec2 roughness_occlusion = unpackUnorm4x8(packed.z).xy;
  s.roughness = roughness_occlusion.x;
  s.occlusion = roughness_occlusion.y;
  s.emissive = has_feature(FEATURE_EMISSIVE) ? unpack_shared_exponent(packed.w) : vec3(0.0);
  s.position = vec3(0.0);
  return s;
}

#endif
