// Where a pixel's aggregates lie: a buffer by address, the words of one aggregate together, the aggregates of one pixel
// together. What fragments add lies in another, the words of one together.
// Reads: AgaaState. Needs frame.glsl, AGGREGATES and aggregate.glsl.
#ifndef SUBPIXEL_AGAA_SUMS_ACCESS_GLSL
#define SUBPIXEL_AGAA_SUMS_ACCESS_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer AggregateSums { uint words[]; };
layout(set = 0, binding = STORAGE(AGAA_SLOT_STATE), scalar) readonly buffer AggregateState { AgaaState state; };

uint first_word(ivec2 pixel, uint aggregate) {
  return ((uint(pixel.y) * uint(frame.viewport.x) + uint(pixel.x)) * AGGREGATES + aggregate) * kAggregateWords;
}

AggregateWords stored_words(ivec2 pixel, uint aggregate) {
  AggregateWords words;
  uint first = first_word(pixel, aggregate);
  for (uint i = 0u; i < kAggregateWords; ++i) words.word[i] = state.sums.words[first + i];
  return words;
}

#endif
