// The scene's picture, graded: a post pass. Reads: the scene's colour target. Writes: colour.
#version 450
layout(location = 0) in vec2 texture_uv;
layout(location = 0) out vec4 colour;
#ifdef VULKAN
layout(set = 0, binding = 2) uniform sampler2D scene_colour;
#else
layout(binding = 2) uniform sampler2D scene_colour;
#endif

void main() {
  colour = pow(texture(scene_colour, texture_uv), vec4(0.9));
}
