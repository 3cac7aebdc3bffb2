// Material textures and factors at one point of a surface.
// Reads: set 1, the material's textures (white where it has none); FEATURES removes what no material of the scene has.
#ifndef SUBPIXEL_MATERIAL_GLSL
#define SUBPIXEL_MATERIAL_GLSL

#include "include/material_factors.glsl"

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

// Fills all of `s` but its position from the material's textures; vertex_normal and tangent as apply_material() has
// them. Gradients are of uv per pixel in x and y.
void evaluate_material(MaterialRecord m, vec2 uv, vec2 duv_dx, vec2 duv_dy, vec3 vertex_normal, vec4 tangent,
                       inout Surface s) {
  MaterialTexels texels = MaterialTexels(vec4(1.0), vec2(1.0), vec3(1.0), vec3(1.0));
  if (has_feature(FEATURE_BASE_TEXTURE)) texels.base_colour = textureGrad(base_colour_texture, uv, duv_dx, duv_dy);
  if (has_feature(FEATURE_ROUGHNESS_TEXTURE))
    texels.roughness_metallic = textureGrad(metallic_roughness_texture, uv, duv_dx, duv_dy).gb;
  if (has_feature(FEATURE_NORMAL_MAP)) texels.normal = textureGrad(normal_texture, uv, duv_dx, duv_dy).rgb;
  if (has_feature(FEATURE_EMISSIVE_TEXTURE)) texels.emissive = textureGrad(emissive_texture, uv, duv_dx, duv_dy).rgb;
  apply_material(m, texels, vertex_normal, tangent, s);
}

#endif
