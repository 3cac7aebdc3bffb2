// variants: SOLID= TESTED=-DTESTED=1 COLOURED=-DTESTED=1,-DCOLOURED=1
// Computes: the sun's clip position of a vertex, with TESTED its texture coordinates, with COLOURED its colour's alpha.
// Reads: vertex streams and instances by address.
// Writes: gl_Position, uv, alpha.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "scene/buffers.glsl"

layout(push_constant, scalar) uniform Push { ShadowPush push; };

#ifdef TESTED
layout(location = 0) out vec2 uv;
#endif
#ifdef COLOURED
layout(location = 1) out float alpha;
#endif

void main() {
  vec4 local = vec4(push.positions.position[gl_VertexIndex], 1.0);
  vec4 row0 = push.instances.instance[gl_InstanceIndex].world_row[0];
  vec4 row1 = push.instances.instance[gl_InstanceIndex].world_row[1];
  vec4 row2 = push.instances.instance[gl_InstanceIndex].world_row[2];
  gl_Position = push.world_to_clip * vec4(dot(row0, local), dot(row1, local), dot(row2, local), 1.0);
#ifdef TESTED
  uv = push.uvs.uv[gl_VertexIndex];
#endif
#ifdef COLOURED
  alpha = push.colours.colour[gl_VertexIndex].a;
#endif
}
