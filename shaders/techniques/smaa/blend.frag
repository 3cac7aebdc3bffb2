#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Mixes a pixel with its neighbours across its edges, those that are level or those that are upright: whichever weigh
// more.
// Reads: weights of blending; the pixels' resolvable values; edges, for the map.
// Writes: linear radiance with the lighting executions in a; display values; the edges of the pixel; its neighbours'
// share in 255ths.
#include "include/resolve.glsl"
#include "techniques/smaa/smaa_interface.h"

layout(set = 0, binding = SAMPLED(SMAA_SLOT_VALUES)) uniform sampler2D values;
layout(set = 0, binding = SAMPLED(SMAA_SLOT_EDGES)) uniform usampler2D edges;
layout(set = 0, binding = SAMPLED(SMAA_SLOT_WEIGHTS)) uniform usampler2D weights;
layout(push_constant, scalar) uniform Push { SmaaBlendPush push; };

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;
layout(location = 2) out uint out_edges;
layout(location = 3) out uint out_blended;

#ifdef STORY
#include "techniques/smaa/story_interface.h"
layout(set = 0, binding = STORAGE(SMAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, how many
  SmaaBlendStory story;
};
bool is_told() { return ivec2(gl_FragCoord.xy) == ivec2(told.xy); }
void tell_weights(vec4 weights, bool sideways, vec3 own, vec3 before, vec3 after) {
  for (bool tell = is_told(); tell; tell = false) {
    story.weights = weights;
    story.head = uvec4(sideways ? 1u : 0u, 0u, 0u, 0u);
    story.own = vec4(own, 0.0);
    story.before = vec4(before, 0.0);
    story.after = vec4(after, 0.0);
    story.mixed = vec4(own, 0.0);
    told.z = 1u;
  }
}
void tell_mixed(vec3 mixed, float share) {
  for (bool tell = is_told(); tell; tell = false) {
    story.head.y = 1u;
    story.mixed = vec4(mixed, share);
  }
}
#define TELL(what) what
#else
#define TELL(what)
#endif

bool displayed_values() { return push.blend == SMAA_BLENDS_DISPLAYED && RESOLVE_TONE_MAPPED == 0u; }

ivec2 within(ivec2 p) { return clamp(p, ivec2(0), textureSize(values, 0) - 1); }

vec3 value_at(ivec2 p) {
  vec3 value = texelFetch(values, within(p), 0).rgb;
  return displayed_values() ? tone_curve(value * frame.tone.x) : value;
}

float weight_at(ivec2 p, int byte) {
  return float(bitfieldExtract(texelFetch(weights, within(p), 0).r, 8 * byte, 8)) / 255.0;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 own = texelFetch(values, p, 0);
  float north = weight_at(p, 0), south = weight_at(p + ivec2(0, 1), 1);
  float west = weight_at(p, 2), east = weight_at(p + ivec2(1, 0), 3);
  bool sideways = max(east, west) > max(south, north);
  ivec2 towards = sideways ? ivec2(1, 0) : ivec2(0, 1);
  float after = sideways ? east : south, before = sideways ? west : north, sum = after + before;
  TELL(tell_weights(vec4(north, south, west, east), sideways, value_at(p), value_at(p - towards),
                    value_at(p + towards));)
  vec3 radiance = resolved_radiance(own.rgb);
  float share = 0.0;
  if (sum > 0.0) {
    vec3 value = value_at(p);
    vec3 mixed = (after * mix(value, value_at(p + towards), after) + before * mix(value, value_at(p - towards), before)) / sum;
    radiance = displayed_values() ? radiance_of_tone(mixed) : resolved_radiance(mixed);
    share = (after * after + before * before) / sum;
    TELL(tell_mixed(mixed, share);)
  }
  out_radiance = vec4(radiance, own.a);
  out_display = vec4(display_from_radiance(radiance), 1.0);
  out_edges = uint(bitCount(texelFetch(edges, p, 0).r));
  out_blended = uint(share * 255.0 + 0.5);
}
