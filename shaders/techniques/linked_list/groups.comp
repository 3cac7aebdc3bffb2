#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The workgroups that light the dynamic blocks.
// Reads: how many there are. Writes: three group counts.
layout(local_size_x = 1) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "deferred/pixel_list.glsl"
#include "techniques/linked_list/blocks.glsl"

layout(set = 0, binding = STORAGE(LINK_SLOT_GROUPS), scalar) writeonly buffer Groups { uint groups[3]; };

void main() {
  uint count = (min(pool.allocated, pool.capacity) + kPixelGroup - 1u) / kPixelGroup;
  groups[0] = min(count, kRowGroups);
  groups[1] = (count + kRowGroups - 1u) / kRowGroups;
  groups[2] = 1u;
}
