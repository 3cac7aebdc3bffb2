#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Merges each pixel's kept fragments in submission order, as merge.frag does one by one; one invocation for each pixel.
// Reads: fragments, their surfaces, the camera. Writes: the pixel's state.
layout(local_size_x = 64) in;
#include "techniques/dcaa/dcaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/dcaa/merge.glsl"
#include "techniques/dcaa/state.glsl"
#include "techniques/dcaa/listed.glsl"

layout(set = 0, binding = STORAGE(DCAA_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(push_constant, scalar) uniform Push { OrderedMergePush push; };

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

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uvec2 part = merged_part(list_range(push.lists, p).x, push.kept.count[p], push.part);
  bool follows = push.part > 0u;
  if (follows && part.x == part.y) return;
  DcaaState state;
  for (uint i = 0u; i < MAX_STATE_WORDS; ++i) state.word[i] = 0u;
  for (bool go = follows; go; go = false)
    for (uint i = 0u; i < STATE_QUADS; ++i) SET_QUAD_OF(state.word, i, push.state.quads[p * STATE_QUADS + i])
  DcaaSurface surface[DCAA_MAX_SURFACES];
  for (uint i = 0u; i < SURFACES; ++i) surface[i] = dcaa_unpack(state, i);
  uint word = state.word[0];
  // The first fragment is the first surface, whatever it is.
  uint begin = part.x;
  for (bool any = !follows && part.x < part.y; any; any = false) {
    surface[0] = listed_surface(push.lists.numbers.number[begin]);
    word = 1u;
    ++begin;
  }
  for (bool go = begin < part.y; go; go = false) {
    DcaaView camera = view;
    vec3 ray = dcaa_ray(pixel, camera);
    DcaaPlane plane[DCAA_MAX_SURFACES];
    plane[0] = dcaa_plane(surface[0], ray, camera);
    for (uint i = 1u; i < SURFACES; ++i) plane[i] = DcaaPlane(vec3(0.0), vec2(0.0));
    for (bool again = follows; again; again = false)
      for (uint i = 1u; i < SURFACES; ++i) plane[i] = dcaa_plane(surface[i], ray, camera);
    for (uint i = begin; i < part.y; ++i)
      dcaa_add(word, surface, plane, listed_surface(push.lists.numbers.number[i]), ray, camera);
  }
  state.word[0] = word;
  for (uint i = 0u; i < SURFACES; ++i) dcaa_pack(surface[i], i, state);
  for (uint i = 0u; i < STATE_QUADS; ++i) push.state.quads[p * STATE_QUADS + i] = QUAD_OF(state.word, i);
}
