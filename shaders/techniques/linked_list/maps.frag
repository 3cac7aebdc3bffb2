#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// What became of each pixel's fragments.
// Reads: visibility, pointers. Writes: blocks that hold a surface, samples of fragments that found the pool full,
// those of them that show the sky because the pixel's own block holds nothing.
#define LINK_READS
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "include/coverage.glsl"
#include "techniques/linked_list/list.glsl"

layout(location = 0) out uint out_blocks;
layout(location = 1) out uint out_overflow;
layout(location = 2) out uint out_leaks;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  LinkWords words = pool.words;
  PixelList list = read_list(words, pixel);
  bool filled = (list.covered & (1u << list.own)) != 0u;
  uint own_triangle = visible_triangles(pixel, SAMPLES, list.own / 4u)[list.own & 3u];
  uint own = filled ? bitCount(samples_of(pixel, own_triangle)) : 0u;
  out_blocks = bitCount(list.leaders);
  out_overflow = bitCount(list.covered) - list.listed - own;
  out_leaks = filled ? 0u : out_overflow;
}
