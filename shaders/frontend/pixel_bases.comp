#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: SUM=-DSUM BASE=-DBASE
// From how many fragments each pixel has to where its part of the numbers begins; one invocation for 64 pixels.
// Reads and writes: the pixels' counts, then bases; the sums (x) of each 64 of them, which are scanned in between.
layout(local_size_x = 64) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_ITEMS), scalar) buffer Pixels { uint pixels[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) buffer Sums { uvec4 sums[]; };
layout(push_constant, scalar) uniform Push { PixelBasesPush push; };

void main() {
  uint group = gl_GlobalInvocationID.x;
  if (group >= push.groups) return;
  uint first = 64u * group, last = min(first + 64u, push.count);
#ifdef SUM
  uint sum = 0u;
  for (uint i = first; i < last; ++i) sum += pixels[i];
  sums[group] = uvec4(sum, 0u, 0u, 0u);
#else
  uint running = sums[group].x;
  for (uint i = first; i < last; ++i) {
    uint own = pixels[i];
    pixels[i] = running;
    running += own;
  }
#endif
}
