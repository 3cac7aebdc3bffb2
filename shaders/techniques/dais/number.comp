#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: FIRST=-DFIRST RECORD=-DRECORD
// Numbers the triangles that show, in submission order: fragments of one triangle stand together, so its first one tells.
// FIRST marks those, for a scan; RECORD leaves each stored triangle its record. One invocation for each fragment, and one more.
// Reads: fragments. Writes: FIRST, the numbers; RECORD, the triangles' first words.
layout(local_size_x = 64) in;
#include "include/frame.glsl"
#include "frontend/fragment_lists.glsl"
#include "techniques/dais/triangles.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_LISTS), scalar) readonly buffer Lists { ListAddresses lists; };
layout(push_constant, scalar) uniform Push { DaisNumberPush push; };

void main() {
  uint i = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  TriangleBuffer to = triangles;
#ifdef FIRST
  if (i > push.fragments) return;
  Fragments fragments = lists.fragments;
  bool first = i == 0u && push.fragments > 0u;
  if (i > 0u && i < push.fragments) first = fragments.fragment[i - 1u].x != fragments.fragment[i].x;
  to.numbers.number[i] = first ? 1u : 0u;
#else
  if (i >= push.fragments) return;
  uint triangle = to.numbers.number[i];
  if (to.numbers.number[i + 1u] == triangle || triangle >= to.capacity) return;
  to.words.word[triangle * kTriangleWords] = lists.fragments.fragment[i].x;
#endif
}
