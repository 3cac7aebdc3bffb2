#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Merges one pixel's kept fragments as merge_lists.comp does and tells of each step.
// Reads: fragments, their surfaces, the camera, which pixel. Writes: the steps.
layout(local_size_x = 64) in;
#include "techniques/dcaa/dcaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/dcaa/merge.glsl"
#include "techniques/dcaa/state.glsl"
#include "techniques/dcaa/listed.glsl"
#include "techniques/dcaa/story_interface.h"

layout(set = 0, binding = STORAGE(DCAA_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(push_constant, scalar) uniform Push { OrderedMergePush push; };
layout(set = 0, binding = STORAGE(DCAA_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, steps
  DcaaStep step_at[];
};

DcaaSurface listed_surface(uint number) {
  uvec4 words = push.surfaces.surface[number].words, more = push.surfaces.surface[number].more;
  DcaaSurface fragment;
  fragment.coverage = push.lists.fragments.fragment[number].zw;
  fragment.facet = uvec3(words.x, more.zw);
  fragment.depth = uintBitsToFloat(words.y);
  fragment.albedo = words.z;
  fragment.normal = words.w;
  fragment.roughness = more.x;
  fragment.emission = more.y;
  fragment.moments = dcaa_moments_of(fragment.normal);
  return fragment;
}

DcaaStorySurface story_of(DcaaSurface s, DcaaSurface fragment, vec3 ray, DcaaView camera) {
  DcaaPlane plane = dcaa_plane(s, ray, camera), its = dcaa_plane(fragment, ray, camera);
  vec3 facet = plane.normal, own = its.normal;
  vec2 interval = dcaa_interval(plane, s.depth);
  precise float cosine = own.x * facet.x + own.y * facet.y + own.z * facet.z;
  DcaaStorySurface story;
  story.words = uvec4(s.coverage, s.facet.x, floatBitsToUint(s.depth));
  story.more = uvec4(s.albedo, s.normal, s.roughness, s.emission);
  story.facet = vec4(facet, s.depth);
  story.interval = vec4(interval, cosine, dcaa_shared_depth(interval, dcaa_interval(its, fragment.depth)));
  return story;
}

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (pixel != ivec2(told.xy)) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uint begin = list_range(push.lists, p).x, end = begin + push.kept.count[p];
  DcaaState state;
  for (uint i = 0u; i < MAX_STATE_WORDS; ++i) state.word[i] = 0u;
  DcaaSurface surface[DCAA_MAX_SURFACES];
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);
  DcaaView camera = view;
  vec3 ray = dcaa_ray(pixel, camera);
  uint word = 0u;
  for (uint i = begin; i < end; ++i) {
    uint number = push.lists.numbers.number[i], step_number = i - begin;
    DcaaSurface fragment = listed_surface(number);
    uint count = field_of(word, 0u, DCAA_COUNT_BITS);
    DcaaSurface brings = fragment;
    if (dcaa_option(DCAA_SHOWN_PART)) brings.coverage = dcaa_not_hidden(count, surface, fragment, ray, camera);
    step_at[step_number].fragment = story_of(brings, fragment, ray, camera);
    for (uint s = 0u; s < SURFACES; ++s) step_at[step_number].before[s] = story_of(surface[s], fragment, ray, camera);
    uint before = word;
    dcaa_add(word, surface, fragment, ray, camera);
    step_at[step_number].head = uvec4(number, before, word, 0u);
    for (uint s = 0u; s < SURFACES; ++s) step_at[step_number].after[s] = story_of(surface[s], fragment, ray, camera);
  }
  told.z = end - begin;
}
