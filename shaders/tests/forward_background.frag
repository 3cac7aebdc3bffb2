#version 460
#extension GL_GOOGLE_include_directive : require
// The sky in the samples that nothing covers, before the fragments are added.
// Reads: visibility.
// Writes: rgb the resolvable sky times those samples, a no lighting execution.
#include "include/resolve.glsl"
#include "include/visibility.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(location = 0) out vec4 out_sum;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint uncovered = 0u;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    uvec4 none = uvec4(equal(visible_triangles(pixel, SAMPLES, quad), uvec4(SUBPIXEL_NO_TRIANGLE)));
    uncovered += none.x + none.y + none.z + none.w;
  }
  out_sum = vec4(resolvable(frame.sky.rgb) * float(uncovered), 0.0);
}
