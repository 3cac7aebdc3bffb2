#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Smooths the steps of edges in a finished image: finds how far a pixel is from the ends of its step and mixes it with the
// pixel across the edge by the area a straight edge would cut off.
// Reads: display values, whose luminance shows the edges; the pixels' resolvable values, which are mixed.
// Writes: linear radiance with the lighting executions in a; display values; one where the pixel changed.
#include "include/resolve.glsl"
#include "techniques/fxaa/fxaa_interface.h"

layout(set = 0, binding = SAMPLED(FXAA_SLOT_DISPLAYED)) uniform sampler2D displayed;
layout(set = 0, binding = SAMPLED(FXAA_SLOT_VALUES)) uniform sampler2D values;
layout(push_constant, scalar) uniform Push { FxaaPush push; };

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;
layout(location = 2) out uint out_changed;

float luminance(ivec2 p) {
  p = clamp(p, ivec2(0), textureSize(displayed, 0) - 1);
  return dot(texelFetch(displayed, p, 0).rgb, vec3(0.299, 0.587, 0.114));
}

#include "techniques/fxaa/story.glsl"

// Pixels to the end of the step that passes `from` in direction `along`, and by how much the two sides' mean differs there
// from `edge`, their mean at the start. `across` leads to the other side.
float steps_to_end(ivec2 from, ivec2 along, ivec2 across, float edge, float tolerance, out float difference) {
  difference = 0.0;
  uint k = 0u;
  for (bool more = push.steps > 0u; more;) {
    ++k;
    ivec2 p = from + int(k) * along;
    difference = 0.5 * (luminance(p) + luminance(p + across)) - edge;
    TELL(tell_step(k, along, difference);)
    more = abs(difference) < tolerance && k < push.steps;
  }
  return float(k);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float m = luminance(pixel);
  float n = luminance(pixel + ivec2(0, -1)), s = luminance(pixel + ivec2(0, 1));
  float w = luminance(pixel + ivec2(-1, 0)), e = luminance(pixel + ivec2(1, 0));
  float highest = max(m, max(max(n, s), max(w, e))), lowest = min(m, min(min(n, s), min(w, e)));
  float contrast = highest - lowest;
  TELL(tell_luma(pixel, highest, lowest);)
  float share = 0.0;  // of the pixel across the edge
  ivec2 across = ivec2(0);
  for (bool edge_here = contrast >= max(push.least_contrast, push.relative_threshold * highest); edge_here;
       edge_here = false) {
    float nw = luminance(pixel + ivec2(-1, -1)), ne = luminance(pixel + ivec2(1, -1));
    float sw = luminance(pixel + ivec2(-1, 1)), se = luminance(pixel + ivec2(1, 1));
    // Second differences down the three columns and along the three rows: the larger ones cross the edge.
    float down = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * m) + abs(ne + se - 2.0 * e);
    float right = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * m) + abs(sw + se - 2.0 * s);
    bool level = down >= right;
    float before = level ? n : w, after = level ? s : e;
    bool towards_after = abs(after - m) > abs(before - m);
    across = (level ? ivec2(0, 1) : ivec2(1, 0)) * (towards_after ? 1 : -1);
    ivec2 along = level ? ivec2(1, 0) : ivec2(0, 1);
    float other = towards_after ? after : before;

    float edge = 0.5 * (m + other), tolerance = 0.25 * abs(other - m);
    float difference_back, difference_ahead;
    float back = steps_to_end(pixel, -along, across, edge, tolerance, difference_back);
    float ahead = steps_to_end(pixel, along, across, edge, tolerance, difference_ahead);
    TELL(tell_edge(vec2(down, right), level, edge, tolerance,
                   vec4(back, ahead, difference_back, difference_ahead));)
    // The step has back + ahead - 1 pixels. A straight edge through its middle crosses the boundary between the sides half
    // way, and cuts off the nearer end's pixels by as much as they are from that point.
    float nearer = min(back, ahead);
    float at_end = back < ahead ? difference_back : difference_ahead;
    bool cut_off = push.steps > 0u && abs(at_end) >= tolerance && (at_end > 0.0) != (m > edge);
    share = cut_off ? max(0.5 - (nearer - 0.5) / (back + ahead - 1.0), 0.0) : 0.0;

    // Dots and thin lines have no step to follow: they go by how far the pixel is from its surroundings.
    float surroundings = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    float isolation = smoothstep(0.0, 1.0, clamp(abs(surroundings - m) / contrast, 0.0, 1.0));
    TELL(tell_shares(share, push.blur * isolation * isolation);)
    share = max(share, push.blur * isolation * isolation);
  }
  vec4 own = texelFetch(values, pixel, 0);
  ivec2 neighbour = clamp(pixel + across, ivec2(0), textureSize(values, 0) - 1);
  vec3 mixed = mix(own.rgb, texelFetch(values, neighbour, 0).rgb, share);
  TELL(tell_mixed(across, share, own.rgb, texelFetch(values, neighbour, 0).rgb, mixed);)
  vec3 radiance = resolved_radiance(mixed);
  out_radiance = vec4(radiance, own.a);
  out_display = vec4(display_from_radiance(radiance), 1.0);
  out_changed = share > 0.0 ? 1u : 0u;
}
