// Computes: a corner's clip position in this turn's shifted image, and its triangle's number.
// Reads: corners, turn constants.
// Writes: gl_Position, the number plus 1, the same on all three corners.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "reference/triangles.glsl"

layout(location = 0) flat out uint triangle;

void main() {
  vec4 clip = push.corners.at[gl_VertexIndex];
  gl_Position = vec4(clip.xy + clip.w * turn.shift.zw, clip.zw);
  triangle = uint(gl_VertexIndex) / 3u + 1u;
}
