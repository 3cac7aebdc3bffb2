#version 460
#extension GL_GOOGLE_include_directive : require
// The final images of a pixel from the sum over its samples.
// Reads: rgb the sum, a the lighting executions. Writes: linear radiance with the executions in a; display values.
#include "include/resolve.glsl"
#include "shade/shade_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = SAMPLED(SHADE_SLOT_SUM)) uniform sampler2D samples_sum;
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

void main() {
  vec4 sum = texelFetch(samples_sum, ivec2(gl_FragCoord.xy), 0);
  vec3 radiance = resolved_radiance(sum.rgb / float(SAMPLES));
  out_radiance = vec4(radiance, sum.a);
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
