// What a material's factors and texels make of a surface, however the texels were fetched.
#ifndef SUBPIXEL_MATERIAL_FACTORS_GLSL
#define SUBPIXEL_MATERIAL_FACTORS_GLSL

#include "include/frame.glsl"
#include "include/surface.glsl"

// Texels of one point, white where the material has no texture.
struct MaterialTexels {
  vec4 base_colour;  // times the vertices' colour
  vec2 roughness_metallic;
  vec3 normal;
  vec3 emissive;
};

// `normal` tilted by a tangent-space normal map texel, whose x and y are scaled. `tangent` is in world space with the
// bitangent's sign in w; it need not be unit. A tangent along the normal, zero or not finite leaves the normal as it is.
vec3 perturbed_normal(vec3 normal, vec4 tangent, vec3 texel, float scale) {
  vec3 along = tangent.xyz - normal * dot(normal, tangent.xyz);
  float length_squared = dot(along, along);
  vec3 t = along * inversesqrt(max(length_squared, 1e-20));
  vec3 b = cross(normal, t) * tangent.w;
  vec3 n = texel * 2.0 - 1.0;
  if (has_feature(FEATURE_NORMAL_SCALE)) n.xy *= scale;
  vec3 tilted = t * n.x + b * n.y + normal * max(n.z, 0.01);
  bool usable = length_squared > 1e-20 && length_squared < 1e20;
  return usable ? tilted * inversesqrt(max(dot(tilted, tilted), 1e-20)) : normal;
}

// Fills all of `s` but its position. `vertex_normal`: world space, unit, already on the viewer's side (negated on the
// back faces of two-sided materials). `tangent`: world space; w is the stored sign, times -1 under a mirroring
// transform; on a back face all four components are negated, so that bumps turn with the normal.
void apply_material(MaterialRecord m, MaterialTexels texels, vec3 vertex_normal, vec4 tangent, inout Surface s) {
  s.albedo = m.base_colour.rgb;
  if (has_feature(FEATURE_BASE_TEXTURE | FEATURE_VERTEX_COLOUR)) s.albedo *= texels.base_colour.rgb;
  s.metallic = has_feature(FEATURE_METAL) ? m.metal_rough.x : 0.0;
  s.roughness = m.metal_rough.y;
  if (has_feature(FEATURE_ROUGHNESS_TEXTURE)) {
    s.roughness *= texels.roughness_metallic.x;
    if (has_feature(FEATURE_METAL)) s.metallic *= texels.roughness_metallic.y;
  }
  s.occlusion = 1.0;
  s.emissive = vec3(0.0);
  if (has_feature(FEATURE_EMISSIVE)) {
    s.emissive = m.emissive_cutoff.rgb;
    if (has_feature(FEATURE_EMISSIVE_TEXTURE)) s.emissive *= texels.emissive;
  }
  s.normal = vertex_normal;
  if (has_feature(FEATURE_NORMAL_MAP)) {
    vec3 tilted = perturbed_normal(vertex_normal, tangent, texels.normal, m.metal_rough.z);
    s.normal = (m.flags.x & MATERIAL_NORMAL_MAP) != 0u ? tilted : vertex_normal;
  }
  if (has_feature(FEATURE_UNLIT)) {
    // Black metal that emits: it reflects nothing, at grazing angles either (brdf.glsl).
    bool unlit = (m.flags.x & MATERIAL_UNLIT) != 0u;
    s.emissive = unlit ? clamp(s.albedo, 0.0, 1.0) : s.emissive;
    s.albedo = unlit ? vec3(0.0) : s.albedo;
    s.metallic = unlit ? 1.0 : s.metallic;
  }
}

#endif
