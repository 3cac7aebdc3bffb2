// variants: TESTED= COLOURED=-DCOLOURED=1
// Computes: whether an alpha-tested surface is there.
// Reads: uv, the material's record and base colour texture; with COLOURED the vertices' alpha.
// Writes: depth, unless discarded.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "include/material.glsl"
#include "scene/buffers.glsl"

layout(set = 0, binding = STORAGE(FRAME_SLOT_MATERIALS), std430) readonly buffer Materials { MaterialRecord materials[]; };
layout(push_constant, scalar) uniform Push { ShadowPush push; };
layout(location = 0) in vec2 uv;
#ifdef COLOURED
layout(location = 1) in float vertex_alpha;
#endif

void main() {
  MaterialRecord m = materials[push.material];
  VertexInputs v;
  v.first = TextureCoordinates(uv, dFdx(uv), dFdy(uv));
  v.second = v.first;
  v.colour = vec4(1.0);
  TextureCoordinates c = coordinates_of(m, 0u, v);
  float alpha = material_alpha(m, c.uv, c.dx, c.dy);
#ifdef COLOURED
  alpha *= vertex_alpha;
#endif
  if (alpha < m.emissive_cutoff.w) discard;
}
