#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Forward shading: each fragment that any sample shows is lit once, for all samples that show it.
// Reads: visibility, which stands for depth testing against a finished depth buffer; shadow map.
// Writes (additively): rgb the resolvable value times the samples that show it, a one lighting execution.
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/fragment.glsl"
#include "include/visibility.glsl"
#include "shade/lit_fragment.glsl"

layout(location = 0) out vec4 out_sum;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uvec4 own = uvec4(fragment_triangle());
  uint shown = 0u;
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    uvec4 same = uvec4(equal(visible_triangles(pixel, SAMPLES, quad), own));
    shown += same.x + same.y + same.z + same.w;
  }
  // A loop, so that groups of pixels that show nothing of the triangle skip the lighting.
  for (bool go = shown != 0u; go; go = false) {
    vec2 offset = shading_offset(fragment_edges(pixel), SAMPLES);
    out_sum = vec4(lit_fragment(pixel, offset) * float(shown), 1.0);
  }
  if (shown == 0u) discard;
}
