// A vertex of the test scene, skinned by two bones and moved by its instance. Reads: vertex attributes, the frame's and
// the draw's constants. Writes: clip position, world normal, uv.
#version 450
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in float bone;
layout(location = 4) in vec3 instance_offset;
layout(location = 0) out vec3 world_normal;
layout(location = 1) out vec2 texture_uv;
layout(std140, binding = 0) uniform Camera {
  mat4 view;
  mat4 projection;
  mat4 bones[2];
} camera;
#ifdef VULKAN
layout(push_constant) uniform Object {
#else
layout(std140, binding = 1) uniform Object {
#endif
  mat4 model;
  vec4 settings;  // x: cutoff, below which fragments are discarded; y: opacity; z: 1 where bones move the vertex
} object;

void main() {
  mat4 moved = object.model;
  if (object.settings.z > 0) moved = moved * (camera.bones[0] * (1 - bone) + camera.bones[1] * bone);
  vec4 world = moved * vec4(position, 1) + vec4(instance_offset, 0);
  gl_Position = camera.projection * camera.view * world;
  world_normal = mat3(moved) * normal;
  texture_uv = uv;
}
