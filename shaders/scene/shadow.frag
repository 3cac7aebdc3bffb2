// Computes: whether an alpha-tested surface is there.
// Reads: uv, the material's record and base colour texture.
// Writes: depth, unless discarded.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "include/material.glsl"

layout(set = 0, binding = 1, std430) readonly buffer Materials { MaterialRecord materials[]; };
layout(push_constant, scalar) uniform Push { layout(offset = 88) uint material; };
layout(location = 0) in vec2 uv;

void main() {
  MaterialRecord m = materials[material];
  if (material_alpha(m, uv, dFdx(uv), dFdy(uv)) < m.emissive_cutoff.w) discard;
}
