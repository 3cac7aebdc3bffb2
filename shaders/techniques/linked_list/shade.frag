#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// The lighting pass: one lighting execution for each block of the pixel's list, weighted by its samples; or, when light.comp
// has lit the dynamic blocks, of the pixel's own, and the sum.
// Reads: visibility, blocks, shadow map. Writes: linear radiance with the lighting executions in a; display values.
#define LINK_READS
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "techniques/linked_list/list.glsl"
#include "techniques/linked_list/read_surface.glsl"
#include "story/lighting.glsl"

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  LinkWords words = pool.words;
  PixelList list = read_list(words, pixel);
  vec3 sum = vec3(0.0);
  uint shown = 0u;
  // By blocks, the lists hold lit values and the pixel's own block is left.
  uint left = LIGHTING == LINK_LIGHT_BLOCKS ? list.leaders & (list.covered & (1u << list.own)) : list.leaders;
  for (; left != 0u; left &= left - 1u) {
    uint s = uint(findLSB(left)), link = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) link = s == i ? list.link[i] : link;
    uint block = link == 0u ? pixel_block(pixel) : link_block(link);
    uint count = link == 0u ? own_samples(list) : link_count(link);
    vec3 value = lit_block(words, block, pixel, s);
    TELL_EXECUTION(pixel, block, count, uvec2(1u << s, 0u), sample_position(pixel, s), value);
    sum += float(count) * value;
    shown += count;
  }
  if (LIGHTING == LINK_LIGHT_BLOCKS) {
    for (uint s = 0u; s < SAMPLES; ++s)
      for (bool listed = list.link[s] != 0u; listed; listed = false) {
        uint block = link_block(list.link[s]), count = link_count(list.link[s]);
        vec3 value = unpack_lit(uvec2(words.word[block_word(block, 0u)], words.word[block_word(block, 1u)]));
        TELL_EXECUTION(pixel, block, count, uvec2(1u << s, 0u), sample_position(pixel, s), value);
        sum += float(count) * value;
        shown += count;
      }
  }
  vec3 radiance = resolved_radiance((sum + resolvable(frame.sky.rgb) * float(SAMPLES - shown)) / float(SAMPLES));
  out_radiance = vec4(radiance, float(bitCount(list.leaders)));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
