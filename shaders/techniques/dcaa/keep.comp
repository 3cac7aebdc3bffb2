#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Sorts each pixel's fragments, finds the prepass's bound from them in submission order as prepass.frag does, and keeps those
// that it does not rule out; one invocation for each pixel.
// Reads: records, fragments. Writes: the sorted numbers, the kept ones first; bits and masks of kept fragments.
layout(local_size_x = 64) in;
#include "techniques/dcaa/dcaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#include "frontend/fragment_lists.glsl"
#include "include/ordered_state_lists.glsl"
#include "techniques/dcaa/surface.glsl"
#include "techniques/dcaa/coverage.glsl"
#include "techniques/dcaa/depth_bound.glsl"
#include "techniques/dcaa/listed.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(push_constant, scalar) uniform Push { OrderedKeepPush push; };

#include "frontend/read_ahead.glsl"

// Of a fragment that covers nothing, any.
RecordDepth fragment_record_depth(uint record) { return record_depth(record == kNothing ? 0u : record); }

// Where masks are there already (masks.comp) their loops are left out: they would count even where no lane enters them.
const bool kMakesMasks = (DCAA_OPTIONS & DCAA_MASKS_MADE) == 0u;

uvec2 listed_mask(uint record, ivec2 pixel) {
  uvec4 v01 = push.records.record[record].v01, v2_ref = push.records.record[record].v2_ref;
  return fragment_coverage(pixel_edges(ivec2(v01.xy), ivec2(v01.zw), ivec2(v2_ref.xy), pixel, v2_ref.w));
}

void main() {
  ivec2 pixel = invocation_pixel(gl_WorkGroupID.xy, gl_LocalInvocationID.x);
  if (any(greaterThanEqual(pixel, ivec2(push.width, push.height)))) return;
  uint p = uint(pixel.y) * push.width + uint(pixel.x);
  uvec2 range = list_range(push.lists, p);
  sort_list(push.lists.numbers, range.x, range.y);

  DepthBound b = DepthBound(vec3(0.0), vec3(0.0), uvec2(0u));
  for (bool go = dcaa_option(DCAA_PREPASS) && range.x < range.y; go; go = false) {
    ListEntry first = list_entry(range.x, range.y), second = list_entry(range.x + 1u, range.y);
    RecordDepth depth = fragment_record_depth(first.fragment.x);
    for (uint i = range.x; i < range.y; ++i) {
      uint number = first.number;
      uvec4 fragment = first.fragment;
      DepthPlane plane = plane_of(depth, pixel);
      depth = fragment_record_depth(second.fragment.x);
      first = second;
      second = list_entry(i + 2u, range.y);
      vec3 own = farthest_plane(plane);
      // Loops are skipped when no lane needs them.
      for (bool helps = fragment.x != kNothing && own.x > b.bound.x; helps; helps = false) {
        uvec2 mask = fragment.zw;
        for (bool missing = kMakesMasks && mask == uvec2(0u); missing; missing = false) {
          mask = listed_mask(fragment.x, pixel);
          push.lists.fragments.fragment[number] = uvec4(mask == uvec2(0u) ? kNothing : fragment.x, fragment.y, mask);
        }
        for (bool covers_some = mask != uvec2(0u); covers_some; covers_some = false) gather_bound(b, own, mask, kWholePixel);
      }
    }
  }

  uint place = range.x;
  for (bool go = range.x < range.y; go; go = false) {
    ListEntry first = list_entry(range.x, range.y), second = list_entry(range.x + 1u, range.y);
    RecordDepth depth = fragment_record_depth(first.fragment.x);
    for (uint i = range.x; i < range.y; ++i) {
      uint number = first.number;
      uvec4 fragment = first.fragment;
      bool keeps = fragment.x != kNothing && may_show(plane_of(depth, pixel), b.bound);
      depth = fragment_record_depth(second.fragment.x);
      first = second;
      second = list_entry(i + 2u, range.y);
      uvec2 mask = fragment.zw;
      for (bool missing = kMakesMasks && keeps && mask == uvec2(0u); missing; missing = false) mask = listed_mask(fragment.x, pixel);
      if (keeps && mask != uvec2(0u)) {
        push.lists.fragments.fragment[number] = uvec4(fragment.x | kKept, fragment.y, mask);
        push.lists.numbers.number[place] = number;
        ++place;
      }
    }
  }
  push.kept.count[p] = place - range.x;
}
