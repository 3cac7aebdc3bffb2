#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Adds up the words of each pixel's fragments, aggregate by aggregate, in submission order; one invocation for each pixel.
// Reads: listed fragments, their words. Writes: the numbers, sorted; the pixel's aggregates.
layout(local_size_x = 64) in;
#include "frontend/fragment_lists.glsl"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/agaa/aggregate.glsl"

layout(constant_id = AGAA_CONSTANT_AGGREGATES) const uint AGGREGATES = 2u;
layout(push_constant, scalar) uniform Push { VisibleFragmentsPush push; };
#include "techniques/agaa/sums_access.glsl"
#include "techniques/agaa/parts_story.glsl"

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  SKIP_UNTOLD(pixel);
  ListAddresses lists = push.lists;
  uvec2 range = list_range(lists, uint(pixel.y) * push.width + uint(pixel.x));
  sort_list(lists.numbers, range.x, range.y);
  for (uint k = 0u; k < AGGREGATES; ++k) {
    AggregateWords sum;
    for (uint i = 0u; i < kAggregateWords; ++i) sum.word[i] = 0u;
    for (uint at = range.x; at < range.y; ++at) {
      uint number = lists.numbers.number[at];
      // A loop, so that groups of pixels without such a fragment skip its words.
      for (bool own = lists.fragments.fragment[number].w == k; own; own = false) {
        for (uint i = 0u; i < kAggregateWords; ++i)
          sum.word[i] = sum_of_words(i, sum.word[i], state.parts.words[number * kAggregateWords + i]);
        TELL_FRAGMENT(pixel, k, number);
      }
    }
    TELL_SUM(pixel, k, sum);
    uint base = first_word(pixel, k);
    for (uint i = 0u; i < kAggregateWords; ++i) state.sums.words[base + i] = sum.word[i];
  }
}
