#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The lighting pass: one lighting execution for each block of the pixel's list, weighted by its samples.
// Reads: visibility (slot 0), blocks, shadow map. Writes: linear radiance with the lighting executions in a; display values.
layout(constant_id = 0) const uint SAMPLES = 8u;
#include "include/lights.glsl"
#include "include/packing.glsl"
#include "include/resolve.glsl"
#include "include/coverage.glsl"
#include "techniques/linked_list/list.glsl"

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

Surface read_surface(LinkWords words, uint block) {
  uint bytes = words.word[shared_word(block)] >> (8u * (block & 1u));
  uint emission = has_feature(FEATURE_EMISSIVE) ? words.word[emission_word(block)] : 0u;
  return unpack_surface(uvec4(words.word[block_word(block, 0u)], words.word[block_word(block, 1u)],
                              (bytes & 255u) | (bytes & 0xff0000u) >> 8, emission));
}

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  LinkWords words = pool.words;
  PixelList list = read_list(words, pixel);
  vec3 sum = vec3(0.0);
  uint shown = 0u, executions = 0u;
  for (uint left = list.leaders; left != 0u; left &= left - 1u) {
    uint s = uint(findLSB(left)), link = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) link = s == i ? list.link[i] : link;
    uint block = link == 0u ? pixel_block(pixel) : link_block(link);
    uint count = link == 0u ? own_samples(list) : link_count(link);
    vec2 offset = vec2(sample_offset(SAMPLES, s)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
    Surface surface = read_surface(words, block);
    surface.position = world_position(gl_FragCoord.xy + offset, uintBitsToFloat(visible_depths(pixel, SAMPLES, s / 4u)[s & 3u]));
    sum += float(count) * resolvable(shade(surface, normalize(frame.eye.xyz - surface.position)));
    shown += count;
    ++executions;
  }
  vec3 radiance = resolved_radiance((sum + resolvable(frame.sky.rgb) * float(SAMPLES - shown)) / float(SAMPLES));
  out_radiance = vec4(radiance, float(executions));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
