#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: BUFFER= TILED_IMAGE=-DTILED,-DIMAGE TILED_BUFFER=-DTILED STORY=-DSTORY
// Resolve (Kerzner and Salvi 2014, section 3.3): visibility of each sample from the surfaces' planes, one lighting execution
// for each surface that any sample shows, their mean by samples.
// Reads: the pixel's state, shadow map. Writes: linear radiance with the lighting executions in a; display values.
#include "techniques/streaming/streaming_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "techniques/streaming/state_read.glsl"
#include "techniques/streaming/plane.glsl"
#include "story/lighting.glsl"

layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

// The surfaces' places in front-to-back order, and what each shows.
struct Shown {
  float depth[STREAM_MAX_SURFACES];
  vec2 slope[STREAM_MAX_SURFACES];
  uint coverage[STREAM_MAX_SURFACES];
  uint samples[STREAM_MAX_SURFACES];  // mask
};

float depth_at(Shown shown, uint place, uint i) {
  vec2 offset = vec2(sample_offset(SAMPLES, i)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
  return shown.depth[place] + shown.slope[place].x * offset.x + shown.slope[place].y * offset.y;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint word = read_count_word(pixel);
  uint count = field_of(word, 0u, STREAM_COUNT_BITS), order = field_of(word, STREAM_ORDER_SHIFT, STREAM_ORDER_BITS);
  vec3 sky = resolvable(frame.sky.rgb);
  vec3 sum = vec3(0.0);
  uint covered = 0u, executions = 0u;
  // Loops, here and below, so that groups of pixels skip what none of them needs.
  for (bool any_surface = count > 0u; any_surface; any_surface = false) {
    StreamSurface surface[STREAM_MAX_SURFACES];
    read_surfaces(pixel, surface);
    Shown shown;
    for (uint place = 0u; place < SURFACES; ++place) {
      uint slot = stream_slot(order, place);
      uint slopes = surface[0].slopes, resolved = surface[0].resolved;
      shown.depth[place] = surface[0].depth;
      shown.coverage[place] = surface[0].coverage;
      for (uint i = 1u; i < SURFACES; ++i) {
        shown.depth[place] = slot == i ? surface[i].depth : shown.depth[place];
        shown.coverage[place] = slot == i ? surface[i].coverage : shown.coverage[place];
        slopes = slot == i ? surface[i].slopes : slopes;
        resolved = slot == i ? surface[i].resolved : resolved;
      }
      // Depth-tested masks share no sample; the planes are compared where only intervals are known.
      if (stream_option(STREAM_DEPTH_TESTED)) shown.coverage[place] = resolved;
      shown.coverage[place] = place < count ? shown.coverage[place] : 0u;
      shown.slope[place] = unpackHalf2x16(slopes);
      shown.samples[place] = place == 0u ? shown.coverage[0] : 0u;
    }
    for (bool several = count > 1u; several; several = false) {
      for (uint place = 0u; place < SURFACES; ++place) shown.samples[place] = 0u;
      for (uint i = 0u; i < SAMPLES; ++i) {
        float nearest = 3e38;
        uint owner = SURFACES;
        for (uint place = 0u; place < SURFACES; ++place) {
          float depth = depth_at(shown, place, i);
          bool nearer = (shown.coverage[place] & (1u << i)) != 0u && depth < nearest;
          nearest = nearer ? depth : nearest;
          owner = nearer ? place : owner;
        }
        for (uint place = 0u; place < SURFACES; ++place) shown.samples[place] |= owner == place ? 1u << i : 0u;
      }
    }

    uint left = 0u;  // places yet to shade
    for (uint place = 0u; place < SURFACES; ++place) left |= shown.samples[place] != 0u ? 1u << place : 0u;
    while (left != 0u) {
      uint place = uint(findLSB(left));
      left &= left - 1u;
      uint slot = stream_slot(order, place);
      StreamSurface s = surface[0];
      for (uint i = 1u; i < SURFACES; ++i) s = stream_select(slot == i, surface[i], s);
      uint samples = shown.samples[0];
      for (uint p = 1u; p < SURFACES; ++p) samples = place == p ? shown.samples[p] : samples;
      // The plane's depth at the pixel's centre, within the depths it has where it is seen: never extrapolated.
      float nearest = 3e38, farthest = -3e38;
      vec2 slope = unpackHalf2x16(s.slopes);
      for (uint i = 0u; i < SAMPLES; ++i) {
        vec2 offset = vec2(sample_offset(SAMPLES, i)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
        float depth = s.depth + slope.x * offset.x + slope.y * offset.y;
        bool seen = (s.coverage & (1u << i)) != 0u;
        nearest = seen ? min(nearest, depth) : nearest;
        farthest = seen ? max(farthest, depth) : farthest;
      }
      Surface lit = unpack_surface(uvec4(s.albedo, s.normal, s.roughness | 255u << 8, s.emission));
      if (SAMPLES > 8u && ROUGHNESS_WORDS == 0u) lit.roughness = frame.tone.y;
      lit.position = world_position(vec2(frame_pixel(pixel)) + 0.5, stream_reversed_depth(clamp(s.depth, nearest, farthest), pixel));
      float weight = float(bitCount(samples));
      vec3 value = resolvable(shade(lit, normalize(frame.eye.xyz - lit.position)));
      TELL_EXECUTION(pixel, slot, uint(bitCount(samples)), uvec2(samples, 0u), lit.position, value);
      sum += weight * value;
      covered += bitCount(samples);
      ++executions;
    }
  }
  bool discarded = (word & (1u << STREAM_DISCARD_SHIFT)) != 0u && covered > 0u;
  vec3 mean = discarded ? sum / float(covered) : (sum + sky * float(SAMPLES - covered)) / float(SAMPLES);
  vec3 radiance = resolved_radiance(mean);
  out_radiance = vec4(radiance, float(executions));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
