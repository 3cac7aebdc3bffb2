#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 1=-DGROUP=1 4=-DGROUP=4 8=-DGROUP=8
// Full G-buffer samples: each fragment writes its surface to those of GROUP samples in which its triangle is the visible one.
// Reads: visibility; with GROUP > 1 the attachments, so that the other samples keep their values.
// Writes: one attachment for each sample, as in stored_sample.glsl.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "deferred/stored_sample.glsl"
#include "include/visibility.glsl"

layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;  // which GROUP samples of the pattern

layout(location = 0) out uvec4 out0;
#if GROUP > 1
layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in0;
layout(input_attachment_index = 1, set = 0, binding = INPUT_ATTACHMENT(1)) uniform usubpassInput in1;
layout(input_attachment_index = 2, set = 0, binding = INPUT_ATTACHMENT(2)) uniform usubpassInput in2;
layout(input_attachment_index = 3, set = 0, binding = INPUT_ATTACHMENT(3)) uniform usubpassInput in3;
layout(location = 1) out uvec4 out1;
layout(location = 2) out uvec4 out2;
layout(location = 3) out uvec4 out3;
#endif
#if GROUP > 4
layout(input_attachment_index = 4, set = 0, binding = INPUT_ATTACHMENT(4)) uniform usubpassInput in4;
layout(input_attachment_index = 5, set = 0, binding = INPUT_ATTACHMENT(5)) uniform usubpassInput in5;
layout(input_attachment_index = 6, set = 0, binding = INPUT_ATTACHMENT(6)) uniform usubpassInput in6;
layout(input_attachment_index = 7, set = 0, binding = INPUT_ATTACHMENT(7)) uniform usubpassInput in7;
layout(location = 4) out uvec4 out4;
layout(location = 5) out uvec4 out5;
layout(location = 6) out uvec4 out6;
layout(location = 7) out uvec4 out7;
#endif

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uint own = fragment_triangle();
#if GROUP == 1
  if (visible_sample(pixel).y != own) discard;
  out0 = stored_sample(fragment_surface(pixel, vec2(0.0)));
#else
  bvec4 low = equal(visible_triangles(pixel, SAMPLES, SAMPLE_GROUP * GROUP / 4u), uvec4(own));
#if GROUP > 4
  bvec4 high = equal(visible_triangles(pixel, SAMPLES, SAMPLE_GROUP * GROUP / 4u + 1u), uvec4(own));
  if (!any(low) && !any(high)) discard;
#else
  if (!any(low)) discard;
#endif
  uvec4 stored = stored_sample(fragment_surface(pixel, shading_offset(fragment_edges(pixel), SAMPLES)));
  out0 = low.x ? stored : subpassLoad(in0);
  out1 = low.y ? stored : subpassLoad(in1);
  out2 = low.z ? stored : subpassLoad(in2);
  out3 = low.w ? stored : subpassLoad(in3);
#if GROUP > 4
  out4 = high.x ? stored : subpassLoad(in4);
  out5 = high.y ? stored : subpassLoad(in5);
  out6 = high.z ? stored : subpassLoad(in6);
  out7 = high.w ? stored : subpassLoad(in7);
#endif
#endif
}
