// variants: SOLID= TESTED=-DTESTED=1 COLOURED=-DTESTED=1,-DCOLOURED=1
// Computes: the sun's clip position of a vertex, with TESTED its texture coordinates, with COLOURED its colour's alpha.
// Reads: vertex streams and instances by address.
// Writes: gl_Position, uv, alpha.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "include/shared_types.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvs { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Colours { vec4 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord at[]; };

layout(push_constant, scalar) uniform Push {
  mat4 world_to_clip;
  Positions positions;
  Uvs uvs;  // those that the material's base colour is read by
  Instances instances;
  Colours colours;
  uint material;
};

#ifdef TESTED
layout(location = 0) out vec2 uv;
#endif
#ifdef COLOURED
layout(location = 1) out float alpha;
#endif

void main() {
  vec4 local = vec4(positions.at[gl_VertexIndex], 1.0);
  vec4 row0 = instances.at[gl_InstanceIndex].world_row[0];
  vec4 row1 = instances.at[gl_InstanceIndex].world_row[1];
  vec4 row2 = instances.at[gl_InstanceIndex].world_row[2];
  gl_Position = world_to_clip * vec4(dot(row0, local), dot(row1, local), dot(row2, local), 1.0);
#ifdef TESTED
  uv = uvs.at[gl_VertexIndex];
#endif
#ifdef COLOURED
  alpha = colours.at[gl_VertexIndex].a;
#endif
}
