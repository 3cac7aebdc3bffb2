#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// A triangle list as the device's own rasteriser draws it, with each triangle's number on all its corners.
// Reads: positions, indices and clip matrices by address. Writes: position, number.
#include "frontend/hull_interface.glsl"
layout(location = 0) flat out uint triangle;
void main() {
  vec3 position = push.positions.position[push.indices.index[gl_VertexIndex]];
  gl_Position = push.clip_matrices.clip_from_object[0] * vec4(position, 1.0);
  triangle = uint(gl_VertexIndex) / 3u;
}
