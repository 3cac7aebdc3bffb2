#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: 1=-DGROUP=1 2=-DGROUP=2 4=-DGROUP=4 8=-DGROUP=8 16=-DGROUP=16 1_FAR=-DGROUP=1,-DFAR 2_FAR=-DGROUP=2,-DFAR 4_FAR=-DGROUP=4,-DFAR 8_FAR=-DGROUP=8,-DFAR 16_FAR=-DGROUP=16,-DFAR 1_BY_LANE=-DGROUP=1,-DFAR,-DBY_LANE 2_BY_LANE=-DGROUP=2,-DFAR,-DBY_LANE 4_BY_LANE=-DGROUP=4,-DFAR,-DBY_LANE 8_BY_LANE=-DGROUP=8,-DFAR,-DBY_LANE 16_BY_LANE=-DGROUP=16,-DFAR,-DBY_LANE
#ifndef BY_LANE
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#endif
// Visibility of small triangles: each pixel goes through the list of its block (list_small.comp), in any order: the nearest
// triangle stays, of equal depths the first submitted, which is the one with the smaller number, since small triangles are whole and
// have the records of their slots. FAR reads triangles by address, since they
// pass the size of a bound range; BY_LANE does so, too, and without subgroups.
// Reads: lists by block, small triangles. Writes: the attachments, as visibility.frag does.
#include "include/coverage.glsl"
#include "frontend/frontend_interface.h"
#include "frontend/small_triangles.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = CONSTANT_SAMPLE_GROUP) const uint SAMPLE_GROUP = 0u;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer SmallWords { uint word[]; };
#ifndef FAR
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SMALL_TRIANGLES), scalar) readonly buffer BoundTriangles { uint small_words[]; };
#endif
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_BLOCK_ENDS), scalar) readonly buffer BlockEnds { uint block_end[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_BLOCK_LISTS), scalar) readonly buffer BlockLists { uint listed[]; };
layout(push_constant, scalar) uniform Push { VisibilitySmallPush push; };
#if GROUP < 4
layout(location = 0) out uvec4 out_state;
#else
layout(location = 0) out uvec4 out_texels[GROUP / 2];
#endif

const uint kQuads = (GROUP + 3) / 4;
const uint kWords = 16u;  // of a small triangle

#ifdef FAR
uint small_word(uint at) { return push.small.word[at]; }
#else
uint small_word(uint at) { return small_words[at]; }
#endif

#ifndef BY_LANE
// A small triangle's words 0 to 7 and 8 to 15, one of each to a lane.
struct LaneWords {
  uint low, high;
};

LaneWords lane_words(uint item) {
  uint at = kWords * item + (gl_SubgroupInvocationID & 7u);
  return LaneWords(small_word(at), small_word(at + 8u));
}

uvec4 broadcast_0_to_3(uint words) {
  return uvec4(subgroupBroadcast(words, 0u), subgroupBroadcast(words, 1u), subgroupBroadcast(words, 2u), subgroupBroadcast(words, 3u));
}
uvec4 broadcast_4_to_7(uint words) {
  return uvec4(subgroupBroadcast(words, 4u), subgroupBroadcast(words, 5u), subgroupBroadcast(words, 6u), subgroupBroadcast(words, 7u));
}
#endif
uvec4 four_words(uint at) { return uvec4(small_word(at), small_word(at + 1u), small_word(at + 2u), small_word(at + 3u)); }

uvec4 depths[kQuads], triangles[kQuads];

void compare(ivec2 pixel, SmallTriangle t) {
  uint own = t.depth2_id.y;
  PixelEdges edges = pixel_edges(ivec2(t.v01.xy), ivec2(t.v01.zw), ivec2(t.v2_ref.xy), pixel, 0u);
  DepthPlane plane = depth_plane(t.depth, t.depth2_id.x, reference_pixel(t.v2_ref.z), pixel);
  for (uint q = 0u; q < kQuads; ++q) {
    uvec4 z;
    bvec4 take;
    for (uint i = 0u; i < 4u; ++i) {
      ivec2 offset = sample_offset(SAMPLES, SAMPLE_GROUP * GROUP + (4u * q + i) % GROUP);
      z[i] = floatBitsToUint(sample_depth(plane, offset));
      // Nearer, or as near and submitted earlier.
      take[i] = small_covers(edges, offset) && z[i] + (own < triangles[q][i] ? 1u : 0u) > depths[q][i];
    }
    depths[q] = mix(depths[q], z, take);
    triangles[q] = mix(triangles[q], uvec4(own), take);
  }
}

void main() {
  // Devices shade whole blocks: beyond the border, too, nothing outside the buffers may be read.
  ivec2 pixel = min(pixel_of(gl_FragCoord.xy), ivec2(push.width, push.height) - 1);
  uint block = uint(pixel.y >> kBlockCell.y) * blocks_in_row(push.width) + uint(pixel.x >> kBlockCell.x);
  uint next = block == 0u ? 0u : block_end[block - 1u], end = block_end[block];
  for (uint q = 0u; q < kQuads; ++q) {
    depths[q] = uvec4(0u);
    triangles[q] = uvec4(0u);  // so that a depth of zero, the background's, takes nothing
  }
#ifndef BY_LANE
  // Eight lanes of one block read a triangle together, a word or two each; what a turn needs is read in the turn before. The
  // last one reads too far, but no farther than the small triangles.
  bool together = subgroupAllEqual(block) && (subgroupBallot(true).x & 0xffu) == 0xffu;
  for (bool go = together && next < end; go; go = false) {
    LaneWords ahead = lane_words(listed[next]);
    while (next < end) {
      LaneWords words = ahead;
      ++next;
      ahead = lane_words(min(listed[next], push.count - 1u));
      compare(pixel, SmallTriangle(broadcast_0_to_3(words.low), broadcast_4_to_7(words.low), broadcast_0_to_3(words.high),
                                   broadcast_4_to_7(words.high)));
    }
  }
#endif
  while (next < end) {
    uint at = kWords * listed[next];
    ++next;
    compare(pixel, SmallTriangle(four_words(at), four_words(at + 4u), four_words(at + 8u), four_words(at + 12u)));
  }
  for (uint q = 0u; q < kQuads; ++q) triangles[q] = mix(triangles[q], uvec4(SUBPIXEL_NO_TRIANGLE), equal(depths[q], uvec4(0u)));
#if GROUP == 1
  out_state = uvec4(depths[0].x, triangles[0].x, 0u, 0u);
#elif GROUP == 2
  out_state = uvec4(depths[0].xy, triangles[0].xy);
#else
  for (uint q = 0u; q < kQuads; ++q) {
    out_texels[q] = depths[q];
    out_texels[kQuads + q] = triangles[q];
  }
#endif
}
