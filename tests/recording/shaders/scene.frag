// A lit and textured fragment of the test scene. Reads: its vertex's outputs, the base colour texture. Writes: colour.
#version 450
layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec2 texture_uv;
layout(location = 0) out vec4 colour;
#ifdef VULKAN
layout(set = 0, binding = 2) uniform sampler2D base_colour_map;
layout(push_constant) uniform Object {
#else
layout(binding = 2) uniform sampler2D base_colour_map;
layout(std140, binding = 1) uniform Object {
#endif
  mat4 model;
  vec4 settings;
} object;

void main() {
  vec4 base = texture(base_colour_map, texture_uv);
  if (object.settings.x > 0 && base.a < 0.5) discard;
  float light = 0.4 + 0.6 * max(dot(normalize(world_normal), normalize(vec3(0.3, 0.9, 0.4))), 0);
  colour = vec4(base.rgb * light, object.settings.y * base.a);
}
