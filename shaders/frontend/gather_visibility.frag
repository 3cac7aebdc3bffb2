#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16
// The words that visibility_unordered.frag found, as visibility.frag leaves them.
// Reads: depths and records. Writes: the attachments.
#include "frontend/nearest_words.glsl"
#include "include/coverage.glsl"

layout(push_constant, scalar) uniform Push { NearestPush push; };
#if GROUP < 4
layout(location = 0) out uvec4 out_state;
#else
layout(location = 0) out uvec4 out_texels[GROUP / 2];
#endif

void main() {
  // Devices shade whole blocks: beyond the border, too, nothing outside the buffers may be read.
  ivec2 pixel = min(pixel_of(gl_FragCoord.xy), ivec2(push.width, push.height) - 1);
  uint at = (uint(pixel.y) * push.width + uint(pixel.x)) * GROUP;
  NearestAddresses from = push.nearest;
#if GROUP == 1
  out_state = uvec4(from.depths.word[at], from.records.word[at], 0u, 0u);
#elif GROUP == 2
  out_state = uvec4(from.depths.word[at], from.depths.word[at + 1u], from.records.word[at], from.records.word[at + 1u]);
#else
  for (uint q = 0u; q < GROUP / 4; ++q) {
    for (uint i = 0u; i < 4u; ++i) {
      out_texels[q][i] = from.depths.word[at + 4u * q + i];
      out_texels[GROUP / 4 + q][i] = from.records.word[at + 4u * q + i];
    }
  }
#endif
}
