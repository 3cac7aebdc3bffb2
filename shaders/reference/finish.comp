// Computes: each pixel's mean radiance and its display value.
// Reads: the sums over all turns.
// Writes: the mean in place of the sum, the display value in place of the compensation.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;
#include "include/tone.glsl"
#include "reference/triangles.glsl"

layout(constant_id = REFERENCE_CONSTANT_TONE_MAP_SAMPLES) const uint TONE_MAP_SAMPLES = 0u;

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  uvec2 size = uvec2(frame.viewport.xy);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  uint place = pixel.y * size.x + pixel.x;
  float turns = float(turn.number.y);
  vec3 radiance = max(push.sums.at[place].rgb / turns, vec3(0.0));
  vec3 display = display_from_radiance(radiance);
  if (TONE_MAP_SAMPLES != 0u) display = clamp(push.display_sums.at[place].rgb / turns, 0.0, 1.0);
  push.sums.at[place] = vec4(radiance, 1.0);
  push.compensation.at[place] = vec4(display, 1.0);
}
