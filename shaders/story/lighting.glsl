// How passes that light tell of it: with STORY each execution in the story's pixel goes into a log.
// Reads and writes: the log.
#ifndef SUBPIXEL_STORY_LIGHTING_GLSL
#define SUBPIXEL_STORY_LIGHTING_GLSL

#ifdef STORY
#include "story/story_interface.h"

layout(set = 0, binding = STORAGE(STORY_SLOT_LIGHTING), scalar) buffer Lighting { LightingLog told; };

void tell_execution(ivec2 pixel, uint which, uint weight, uvec2 samples, vec3 position, vec3 value) {
  bool own = pixel == ivec2(told.head.xy) && told.head.z < uint(STORY_MOST_EXECUTIONS);
  for (bool tell = own; tell; tell = false) {
    uint number = told.head.z;
    told.execution[number].of = uvec4(which, weight, samples);
    told.execution[number].position = vec4(position, 1.0);
    told.execution[number].value = vec4(value, 1.0);
    told.head.z = number + 1u;
  }
}
#define TELL_EXECUTION(pixel, which, weight, samples, position, value) \
  tell_execution(pixel, which, weight, samples, position, value)
#else
#define TELL_EXECUTION(pixel, which, weight, samples, position, value)
#endif

#endif
