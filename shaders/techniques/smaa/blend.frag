#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
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
  vec3 radiance = resolved_radiance(own.rgb);
  float share = 0.0;
  if (sum > 0.0) {
    vec3 value = value_at(p);
    vec3 mixed = (after * mix(value, value_at(p + towards), after) + before * mix(value, value_at(p - towards), before)) / sum;
    radiance = displayed_values() ? radiance_of_tone(mixed) : resolved_radiance(mixed);
    share = (after * after + before * before) / sum;
  }
  out_radiance = vec4(radiance, own.a);
  out_display = vec4(display_from_radiance(radiance), 1.0);
  out_edges = uint(bitCount(texelFetch(edges, p, 0).r));
  out_blended = uint(share * 255.0 + 0.5);
}
