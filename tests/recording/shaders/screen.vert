// One triangle over the whole target, or a small one in a corner for the head-up display. Writes: clip position, uv.
#version 450
layout(location = 0) out vec2 texture_uv;
#ifdef VULKAN
#define VERTEX gl_VertexIndex
#else
#define VERTEX gl_VertexID
#endif

void main() {
  texture_uv = vec2(VERTEX == 1 ? 2 : 0, VERTEX == 2 ? 2 : 0);
  gl_Position = vec4(texture_uv * 2 - 1, 0, 1);
}
