#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The driver's own way to draw the scene: a transform for each vertex and nothing else.
// Reads: positions and clip matrices by address. Writes: position.
#include "frontend/hull_interface.glsl"
void main() {
  gl_Position = push.clip_matrices.clip_from_object[gl_InstanceIndex] * vec4(push.positions.position[gl_VertexIndex], 1.0);
}
