// How the pass tells what it does: with STORY that of the story's pixel goes into a log.
// Reads and writes: the log.
#ifdef STORY
#include "techniques/taa/story_interface.h"

layout(set = 0, binding = STORAGE(TAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, stories
  TaaStory story;
};

bool is_told() { return ivec2(gl_FragCoord.xy) == ivec2(told.xy); }

void tell_begin() {
  for (bool tell = is_told(); tell; tell = false) story.head = uvec4(push.has_history, 0u, 0u, 0u);
}

void tell_neighbour(int k, vec3 colour) {
  for (bool tell = is_told(); tell; tell = false) story.neighbourhood[k] = vec4(colour, 0.0);
}

void tell_bounds(vec3 low, vec3 high, bool moves) {
  for (bool tell = is_told(); tell; tell = false) {
    story.low = vec4(low, 0.0);
    story.high = vec4(high, 0.0);
    story.head.w = moves ? 1u : 0u;
  }
}

void tell_motion(ivec2 front, uint triangle, uint instance, float depth, vec2 came_from, float depth_then,
                 bool inside) {
  for (bool tell = is_told(); tell; tell = false) {
    story.front = uvec4(front, triangle, instance);
    story.motion = vec4(came_from, depth, depth_then);
    story.head.y = inside ? 1u : 0u;
  }
}

void tell_history(vec4 before, vec3 kept) {
  for (bool tell = is_told(); tell; tell = false) {
    story.before = before;
    story.kept = vec4(kept, 0.0);
    story.head.z = 1u;
  }
}

void tell_value(vec3 own, float alpha, vec3 value, float frames) {
  for (bool tell = is_told(); tell; tell = false) {
    story.own = vec4(own, alpha);
    story.value = vec4(value, frames);
    told.z = 1u;
  }
}
#define TELL(what) what
#else
#define TELL(what)
#endif
