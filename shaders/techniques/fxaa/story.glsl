// How the filter tells what it does: with STORY that of the story's pixel goes into a log.
// Reads and writes: the log.
#ifdef STORY
#include "techniques/fxaa/story_interface.h"

layout(set = 0, binding = STORAGE(FXAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, stories
  FxaaStory story;
};

bool is_told() { return ivec2(gl_FragCoord.xy) == ivec2(told.xy); }

void tell_luma(ivec2 pixel, float highest, float lowest) {
  for (bool tell = is_told(); tell; tell = false) {
    for (int k = 0; k < 9; ++k) story.luma[k] = luminance(pixel + ivec2(k % 3, k / 3) - 1);
    float threshold = max(push.least_contrast, push.relative_threshold * highest);
    story.contrast = vec4(highest, lowest, highest - lowest, threshold);
  }
}

void tell_step(uint k, ivec2 along, float difference) {
  for (bool tell = is_told(); tell; tell = false)
    if (along.x + along.y < 0) story.back[k - 1u] = difference;
    else story.ahead[k - 1u] = difference;
}

void tell_edge(vec2 curvature, bool level, float edge, float tolerance, vec4 ends) {
  for (bool tell = is_told(); tell; tell = false) {
    story.curvature = vec4(curvature, level ? 1.0 : 0.0, 0.0);
    story.across.zw = vec2(edge, tolerance);
    story.ends = ends;
  }
}

void tell_shares(float of_step, float of_blur) {
  for (bool tell = is_told(); tell; tell = false) story.shares.xy = vec2(of_step, of_blur);
}

void tell_mixed(ivec2 across, float share, vec3 own, vec3 other, vec3 mixed) {
  for (bool tell = is_told(); tell; tell = false) {
    story.across.xy = vec2(across);
    story.shares.z = share;
    story.own = vec4(own, 0.0);
    story.other = vec4(other, 0.0);
    story.mixed = vec4(mixed, 0.0);
    told.z = 1u;
  }
}
#define TELL(what) what
#else
#define TELL(what)
#endif
