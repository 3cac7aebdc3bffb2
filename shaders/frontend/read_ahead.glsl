// A fragment of a pixel's list, read a turn before the one that needs it, its number two turns: each read takes as long as
// memory does, and one depends on the other.
// Needs fragment_lists.glsl, coverage.glsl, and `lists` and `records` among the push constants.
#ifndef SUBPIXEL_READ_AHEAD_GLSL
#define SUBPIXEL_READ_AHEAD_GLSL

struct ListEntry {
  uint number;
  uvec4 fragment;
};

// Entry i, or the last before `end`.
ListEntry list_entry(uint i, uint end) {
  uint number = push.lists.numbers.number[min(i, end - 1u)];
  return ListEntry(number, push.lists.fragments.fragment[number]);
}

// What depth_plane() takes of a record.
struct RecordDepth {
  uvec4 depth;
  uint depth2, reference;
};

RecordDepth record_depth(uint record) {
  return RecordDepth(push.records.record[record].depth, push.records.record[record].depth2.x, push.records.record[record].v2_ref.z);
}

DepthPlane plane_of(RecordDepth d, ivec2 pixel) {
  return depth_plane(d.depth, d.depth2, reference_pixel(d.reference), pixel);
}

#endif
