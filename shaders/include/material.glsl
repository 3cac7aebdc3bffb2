// Material textures and factors at one point of a surface.
// Reads: set 1, the material's textures (white where it has none); the mappings, where textures are transformed.
// FEATURES removes what no material of the scene has.
#ifndef SUBPIXEL_MATERIAL_GLSL
#define SUBPIXEL_MATERIAL_GLSL

#include "include/material_factors.glsl"

layout(set = 1, binding = MATERIAL_SLOT_BASE_COLOUR) uniform sampler2D base_colour_texture;
layout(set = 1, binding = MATERIAL_SLOT_METALLIC_ROUGHNESS) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = MATERIAL_SLOT_NORMAL) uniform sampler2D normal_texture;
layout(set = 1, binding = MATERIAL_SLOT_EMISSIVE) uniform sampler2D emissive_texture;
layout(set = 0, binding = STORAGE(FRAME_SLOT_UV_MAPPINGS), std430) readonly buffer UvMappings { UvMappingRecord uv_mappings[]; };

// Where a texture is read, and its change per pixel in x and y.
struct TextureCoordinates {
  vec2 uv, dx, dy;
};

// What a fragment's vertices give a material. Parts that the scene does not need are 0, the colour 1.
struct VertexInputs {
  TextureCoordinates first, second;
  vec4 colour;
};

// `texture`: its binding above.
TextureCoordinates coordinates_of(MaterialRecord m, uint texture, VertexInputs v) {
  TextureCoordinates c = v.first;
  if (has_feature(FEATURE_SECOND_UV)) {
    bool second = (m.flags.x & (MATERIAL_SECOND_UV << texture)) != 0u;
    c.uv = second ? v.second.uv : c.uv;
    c.dx = second ? v.second.dx : c.dx;
    c.dy = second ? v.second.dy : c.dy;
  }
  if (has_feature(FEATURE_TEXTURE_TRANSFORM)) {
    UvMappingRecord mapping = uv_mappings[m.flags.y + texture];
    vec3 row0 = mapping.row[0].xyz, row1 = mapping.row[1].xyz;
    c.uv = vec2(dot(row0.xy, c.uv) + row0.z, dot(row1.xy, c.uv) + row1.z);
    c.dx = vec2(dot(row0.xy, c.dx), dot(row1.xy, c.dx));
    c.dy = vec2(dot(row0.xy, c.dy), dot(row1.xy, c.dy));
  }
  return c;
}

// Opacity, but for the vertices' part of it, to compare with m.emissive_cutoff.w: visible when not below it.
float material_alpha(MaterialRecord m, vec2 uv, vec2 duv_dx, vec2 duv_dy) {
  float alpha = m.base_colour.a;
  if (has_feature(FEATURE_BASE_TEXTURE)) alpha *= textureGrad(base_colour_texture, uv, duv_dx, duv_dy).a;
  return alpha;
}

vec4 texel_at(sampler2D of, TextureCoordinates c) { return textureGrad(of, c.uv, c.dx, c.dy); }

// Fills all of `s` but its position from the material's textures; vertex_normal and tangent as apply_material() has
// them.
void evaluate_material(MaterialRecord m, VertexInputs v, vec3 vertex_normal, vec4 tangent, inout Surface s) {
  MaterialTexels texels = MaterialTexels(vec4(1.0), vec2(1.0), vec3(1.0), vec3(1.0));
  if (has_feature(FEATURE_BASE_TEXTURE)) texels.base_colour = texel_at(base_colour_texture, coordinates_of(m, 0u, v));
  if (has_feature(FEATURE_VERTEX_COLOUR)) texels.base_colour *= v.colour;
  if (has_feature(FEATURE_ROUGHNESS_TEXTURE))
    texels.roughness_metallic = texel_at(metallic_roughness_texture, coordinates_of(m, 1u, v)).gb;
  if (has_feature(FEATURE_NORMAL_MAP)) texels.normal = texel_at(normal_texture, coordinates_of(m, 2u, v)).rgb;
  if (has_feature(FEATURE_EMISSIVE_TEXTURE)) texels.emissive = texel_at(emissive_texture, coordinates_of(m, 3u, v)).rgb;
  apply_material(m, texels, vertex_normal, tangent, s);
}

#endif
