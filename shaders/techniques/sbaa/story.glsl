// How the analysis tells of each group of samples: with STORY those of the story's pixel go into a log.
// Reads and writes: the log.
#ifdef STORY
#include "techniques/sbaa/story_interface.h"

layout(set = 0, binding = STORAGE(SBAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, steps
  SbaaStep step_at[];
};

void tell_group(uint first, uint samples, uint into, uint count, bool merge, vec3 normal[SAMPLES], float low[SAMPLES],
                float high[SAMPLES]) {
  for (bool tell = ivec2(gl_FragCoord.xy) == ivec2(told.xy); tell; tell = false) {
    uint number = told.z;
    AnalysedSample s = analysed_sample(first);
    step_at[number].head = uvec4(samples, first, into, count);
    step_at[number].face = vec4(s.normal, s.slope);
    step_at[number].depth = vec4(s.depth, 0.0, 0.0, 0.0);
    for (uint j = 0u; merge && j < count; ++j)
      step_at[number].compared[j] = vec4(face_cosine(normal[j], s.normal), low[j], high[j], 0.0);
    told.z = number + 1u;
  }
}
#define TELL_GROUP(first, samples, into, count, merge, normal, low, high) \
  tell_group(first, samples, into, count, merge, normal, low, high)
#else
#define TELL_GROUP(first, samples, into, count, merge, normal, low, high)
#endif
