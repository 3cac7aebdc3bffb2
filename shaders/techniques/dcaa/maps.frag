#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: IMAGE=-DIMAGE BUFFER=
// What the merge pass did to each pixel.
// Reads: the pixel's state, what examine.frag found. Writes, from FIRST_MAP on: surfaces stored, first merges, second merges,
// surfaces discarded, leaks (samples that show the sky though something covers them), wrong decisions of the table.
#include "techniques/dcaa/dcaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#include "techniques/dcaa/surface.glsl"
#include "techniques/dcaa/state.glsl"
#include "techniques/dcaa/state_read.glsl"
#include "techniques/dcaa/found.glsl"

layout(constant_id = DCAA_CONSTANT_FIRST_MAP) const uint FIRST_MAP = 0u;
layout(location = 0) out uint out_maps[DCAA_MAPS_AT_A_TIME];

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint word = read_count_word(pixel);
  uint count = field_of(word, 0u, DCAA_COUNT_BITS);
  DcaaSurface surface[DCAA_MAX_SURFACES];
  read_surfaces(pixel, surface);
  uvec2 covered = uvec2(0u);
  for (uint i = 0u; i < SURFACES; ++i) covered |= i < count ? surface[i].coverage : uvec2(0u);
  uint at = found_word(pixel);
  uvec2 anywhere = uvec2(found.words.word[at], found.words.word[at + 1u]);
  uint maps[2 * DCAA_MAPS_AT_A_TIME] = uint[](
      count, field_of(word, DCAA_FIRST_SHIFT, DCAA_FIRST_BITS), field_of(word, DCAA_SECOND_SHIFT, DCAA_SECOND_BITS),
      field_of(word, DCAA_DISCARD_SHIFT, DCAA_DISCARD_BITS), dcaa_count(anywhere & ~covered), found.words.word[at + 3u]);
  for (uint i = 0u; i < DCAA_MAPS_AT_A_TIME; ++i) out_maps[i] = maps[FIRST_MAP + i];
}
