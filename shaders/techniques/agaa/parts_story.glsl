// How the sums tell of themselves: with STORY those of the story's pixel, and what its fragments add, go into a log.
// Reads and writes: the log.
#ifdef STORY
#include "techniques/agaa/story_interface.h"

layout(set = 0, binding = STORAGE(AGAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, parts
  AgaaPart part_at[];
};

// A fragment's words say what an aggregate of it alone would be.
void tell_part(ivec2 pixel, uint aggregate, AggregateWords words, bool of_fragment) {
  uint mask = aggregate_mask(words.word[kMaskWord]), number = told.z;
  for (bool tell = mask != 0u; tell; tell = false) {
    Aggregate a = aggregate_of_words(words, frame.tone.y, state.largest_emission);
    part_at[number].head = uvec4(aggregate, mask, of_fragment ? 1u : 0u, 0u);
    part_at[number].normal = vec4(a.normal, a.roughness);
    part_at[number].diffuse = vec4(a.diffuse, 0.0);
    part_at[number].reflectance = vec4(a.reflectance, 0.0);
    part_at[number].emissive = vec4(a.emissive, 0.0);
    for (uint i = 0u; i < uint(AGAA_STORY_WORDS); ++i)
      part_at[number].words[i] = i < kAggregateWords ? words.word[min(i, uint(AGAA_MAX_WORDS) - 1u)] : 0u;
    told.z = number + 1u;
  }
}

AggregateWords fragment_part(uint number) {
  AggregateWords words;
  for (uint i = 0u; i < kAggregateWords; ++i) words.word[i] = state.parts.words[number * kAggregateWords + i];
  return words;
}
#define TELL_FRAGMENT(pixel, aggregate, number) tell_part(pixel, aggregate, fragment_part(number), true)
#define TELL_SUM(pixel, aggregate, words) tell_part(pixel, aggregate, words, false)
#define SKIP_UNTOLD(pixel) \
  if (pixel != ivec2(told.xy)) return
#else
#define TELL_FRAGMENT(pixel, aggregate, number)
#define TELL_SUM(pixel, aggregate, words)
#define SKIP_UNTOLD(pixel)
#endif
