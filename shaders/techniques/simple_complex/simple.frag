#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: SIMPLE= BOTH=-DWITH_COMPLEX STORY=-DWITH_COMPLEX,-DSTORY
// Shades the pixels whose samples agree by their sample 0; BOTH: the complex ones too, sample by sample.
// Reads: visibility, G-buffer of full samples, complex flags, shadow map.
// Writes: rgb the sum of the samples' resolvable values, a the lighting executions; nothing for what is not its own.
#include "shade/full_sample.glsl"
#include "techniques/simple_complex/simple_complex_interface.h"

layout(set = 0, binding = SAMPLED(SIMPLE_COMPLEX_SLOT_FLAGS)) uniform usampler2D complex_flags;
layout(location = 0) out vec4 out_sum;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  bool complex = texelFetch(complex_flags, pixel, 0).x != 0u;
  vec4 sum = vec4(0.0);
  for (bool simple = !complex; simple; simple = false) {
    vec4 value = full_sample_value(pixel, 0u, 0u);
    sum = vec4(value.rgb * float(SAMPLES), value.a);
  }
#ifdef WITH_COMPLEX
  for (bool each = complex; each; each = false)
    for (uint s = 0u; s < SAMPLES; ++s) sum += full_sample_value(pixel, s, s);
#endif
  out_sum = sum;
}
