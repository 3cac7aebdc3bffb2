#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Merges one pixel's fragments as merge.comp does and tells of each step.
// Reads: fragments that passed, their surfaces, which pixel. Writes: the steps.
layout(local_size_x = 64) in;
#include "techniques/streaming/streaming_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/streaming/compress.glsl"
#include "techniques/streaming/state.glsl"
#include "techniques/streaming/listed.glsl"
#include "techniques/streaming/story_interface.h"

layout(push_constant, scalar) uniform Push { OrderedMergePush push; };
layout(set = 0, binding = STORAGE(STREAM_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, steps
  StreamStep step_at[];
};

StreamSurface listed_surface(uint number) {
  uvec2 masks = push.lists.fragments.fragment[number].zw;
  uvec4 words = push.surfaces.surface[number].words;
  uvec2 more = push.surfaces.surface[number].more;
  uint resolved = stream_option(STREAM_DEPTH_TESTED) ? masks.y : masks.x;
  return StreamSurface(uintBitsToFloat(words.x), words.y, masks.x, resolved, words.z, words.w, more.x, more.y);
}

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (pixel != ivec2(told.xy)) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uint begin = list_range(push.lists, p).x, end = begin + push.kept.count[p];
  StreamList list;
  for (uint i = 0u; i < MAX_LIST_WORDS; ++i) list.word[i] = 0u;
  uint word;
  StreamSurface surface[STREAM_MAX_SURFACES];
  for (uint i = 0u; i < STREAM_MAX_SURFACES; ++i) surface[i] = StreamSurface(0.0, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  stream_unpack(list, word, surface);
  for (uint i = begin; i < end; ++i) {
    uint number = push.lists.numbers.number[i], step_number = i - begin;
    StreamSurface fragment = listed_surface(number);
    uint count = field_of(word, 0u, STREAM_COUNT_BITS);
    for (uint s = 0u; s < SURFACES; ++s) {
      vec3 a = stream_normal(fragment.normal), b = stream_normal(surface[s].normal);
      precise float cosine = a.x * b.x + a.y * b.y + a.z * b.z;
      float shared_samples = float(bitCount(surface[s].coverage & fragment.coverage));
      step_at[step_number].compared[s] =
          vec4(cosine, stream_interval(surface[s].depth, surface[s].slopes), shared_samples);
    }
    step_at[step_number].interval = vec4(stream_interval(fragment.depth, fragment.slopes), 0.0, 0.0);
    step_at[step_number].fragment[0] =
        uvec4(floatBitsToUint(fragment.depth), fragment.slopes, fragment.coverage, fragment.resolved);
    step_at[step_number].fragment[1] = uvec4(fragment.albedo, fragment.normal, fragment.roughness, fragment.emission);
    uint matches = stream_matches(surface, count, fragment);
    stream_add(word, surface, fragment);
    step_at[step_number].head = uvec4(number, push.lists.fragments.fragment[number].w, word, matches);
    for (uint s = 0u; s < SURFACES; ++s) {
      step_at[step_number].surface[2u * s] =
          uvec4(floatBitsToUint(surface[s].depth), surface[s].slopes, surface[s].coverage, surface[s].resolved);
      step_at[step_number].surface[2u * s + 1u] =
          uvec4(surface[s].albedo, surface[s].normal, surface[s].roughness, surface[s].emission);
    }
  }
  told.z = end - begin;
}
