#version 460
// Triangles that all cover the whole target, some larger, so that tiles are reached by different paths.
// Reads: nothing. Writes: position and the triangle's number.
layout(location = 0) out flat uint out_triangle;
void main() {
  uint triangle = gl_VertexIndex / 3u, corner = gl_VertexIndex % 3u;
  float size = 3.0 + float(triangle % 7u);
  gl_Position = vec4(corner == 1u ? size : -1.0, corner == 2u ? size : -1.0, 0.5, 1.0);
  out_triangle = triangle;
}
