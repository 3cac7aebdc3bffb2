#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: ATTACHMENT= BUFFER=-DBUFFER
// Counts the triangles of a pixel and those that don't follow their predecessor.
// Reads and writes: the pixel's state (next triangle expected, triangles seen, violations) in the attachment, or in a buffer by
// plain reads and writes.
#include "frontend/frontend_interface.h"

layout(location = 0) in flat uint in_triangle;

uvec4 next_state(uvec4 state) {
  return uvec4(in_triangle + 1u, state.y + 1u, state.z + (state.x == in_triangle ? 0u : 1u), 0u);
}

#ifdef BUFFER
layout(constant_id = FRONTEND_CONSTANT_LITMUS_WIDTH) const uint WIDTH = 256u;
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_LITMUS_STATES), std430) buffer States { uvec4 states[]; };
void main() {
  // Never taken. Without a discard lavapipe takes the triangle for opaque and drops whatever a tile that it covers had queued
  // before, storage writes and all; every pass that writes through buffers discards.
  if (in_triangle == 0xffffffffu) discard;
  uint pixel = uint(gl_FragCoord.y) * WIDTH + uint(gl_FragCoord.x);
  states[pixel] = next_state(states[pixel]);
}
#else
layout(input_attachment_index = 0, set = 0, binding = INPUT_ATTACHMENT(0)) uniform usubpassInput in_state;
layout(location = 0) out uvec4 out_state;
void main() { out_state = next_state(subpassLoad(in_state)); }
#endif
