// Material textures and factors at one point of a surface.
// Reads: set 1, the material's textures (white where it has none); FEATURES removes what no material of the scene has.
#ifndef SUBPIXEL_MATERIAL_GLSL
#define SUBPIXEL_MATERIAL_GLSL

#include "include/frame.glsl"
#include "include/surface.glsl"

layout(set = 1, binding = 0) uniform sampler2D base_colour_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D normal_texture;
layout(set = 1, binding = 3) uniform sampler2D emissive_texture;

// Opacity to compare with m.emissive_cutoff.w: visible when not below it.
float material_alpha(MaterialRecord m, vec2 uv, vec2 duv_dx, vec2 duv_dy) {
  float alpha = m.base_colour.a;
  if (has_feature(FEATURE_BASE_TEXTURE)) alpha *= textureGrad(base_colour_texture, uv, duv_dx, duv_dy).a;
  return alpha;
}

// `normal` tilted by a tangent-space normal map texel. `tangent` is in world space with the bitangent's sign in w; it
// need not be unit. A tangent along the normal, zero or not finite leaves the normal as it is.
vec3 perturbed_normal(vec3 normal, vec4 tangent, vec3 texel) {
  vec3 along = tangent.xyz - normal * dot(normal, tangent.xyz);
  float length_squared = dot(along, along);
  vec3 t = along * inversesqrt(max(length_squared, 1e-20));
  vec3 b = cross(normal, t) * tangent.w;
  vec3 n = texel * 2.0 - 1.0;
  vec3 tilted = t * n.x + b * n.y + normal * max(n.z, 0.01);
  bool usable = length_squared > 1e-20 && length_squared < 1e20;
  return usable ? tilted * inversesqrt(max(dot(tilted, tilted), 1e-20)) : normal;
}

// Fills all of `s` but its position. `vertex_normal`: world space, unit, already on the viewer's side (negated on the
// back faces of two-sided materials). `tangent`: world space; w is the stored sign, times -1 under a mirroring
// transform; on a back face all four components are negated, so that bumps turn with the normal.
// Gradients are of uv per pixel in x and y.
void evaluate_material(MaterialRecord m, vec2 uv, vec2 duv_dx, vec2 duv_dy, vec3 vertex_normal, vec4 tangent,
                       inout Surface s) {
  s.albedo = m.base_colour.rgb;
  if (has_feature(FEATURE_BASE_TEXTURE)) s.albedo *= textureGrad(base_colour_texture, uv, duv_dx, duv_dy).rgb;
  s.metallic = has_feature(FEATURE_METAL) ? m.metal_rough.x : 0.0;
  s.roughness = m.metal_rough.y;
  if (has_feature(FEATURE_ROUGHNESS_TEXTURE)) {
    vec2 texel = textureGrad(metallic_roughness_texture, uv, duv_dx, duv_dy).gb;
    s.roughness *= texel.x;
    if (has_feature(FEATURE_METAL)) s.metallic *= texel.y;
  }
  s.occlusion = 1.0;
  s.emissive = vec3(0.0);
  if (has_feature(FEATURE_EMISSIVE)) {
    s.emissive = m.emissive_cutoff.rgb;
    if (has_feature(FEATURE_EMISSIVE_TEXTURE)) s.emissive *= textureGrad(emissive_texture, uv, duv_dx, duv_dy).rgb;
  }
  s.normal = vertex_normal;
  if (has_feature(FEATURE_NORMAL_MAP)) {
    vec3 texel = textureGrad(normal_texture, uv, duv_dx, duv_dy).rgb;
    vec3 tilted = perturbed_normal(vertex_normal, tangent, texel);
    s.normal = (m.flags.x & MATERIAL_NORMAL_MAP) != 0u ? tilted : vertex_normal;
  }
}

#endif
