#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Merges each pixel's fragments in submission order, as compress.frag does one by one; one invocation for each pixel.
// Reads: fragments that passed, their surfaces. Writes: the surfaces of the pixel's state.
layout(local_size_x = 64) in;
#include "techniques/streaming/streaming_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "techniques/streaming/listed.glsl"

layout(push_constant, scalar) uniform Push { OrderedMergePush push; };

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uvec2 part = merged_part(list_range(push.lists, p).x, push.kept.count[p], push.part);
  if (push.part > 0u && part.x == part.y) return;
  StreamList list;
  for (uint i = 0u; i < MAX_LIST_WORDS; ++i) list.word[i] = 0u;
  for (bool follows = push.part > 0u; follows; follows = false)
    for (uint i = 0u; i < LIST_QUADS; ++i) SET_QUAD_OF(list.word, i, push.state.quads[p * LISTED_STATE_QUADS + DEPTH_QUADS + i])
  uint word;
  StreamSurface surface[STREAM_MAX_SURFACES];
  stream_unpack(list, word, surface);
  for (uint i = part.x; i < part.y; ++i) {
    uint number = push.lists.numbers.number[i];
    uvec2 masks = push.lists.fragments.fragment[number].zw;
    uvec4 words = push.surfaces.surface[number].words;
    StreamSurface fragment;
    fragment.depth = uintBitsToFloat(words.x);
    fragment.slopes = words.y;
    fragment.coverage = masks.x;
    fragment.resolved = stream_option(STREAM_DEPTH_TESTED) ? masks.y : masks.x;
    fragment.albedo = words.z;
    fragment.normal = words.w;
    uvec2 more = push.surfaces.surface[number].more;
    fragment.roughness = more.x;
    fragment.emission = more.y;
    stream_add(word, surface, fragment);
  }
  stream_pack(word, surface, list);
  for (uint i = 0u; i < LIST_QUADS; ++i) push.state.quads[p * LISTED_STATE_QUADS + DEPTH_QUADS + i] = QUAD_OF(list.word, i);
}
