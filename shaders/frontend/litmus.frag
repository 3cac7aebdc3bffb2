#version 460
// variants: ATTACHMENT= BUFFER=-DBUFFER
// Counts the triangles of a pixel and those that don't follow their predecessor.
// Reads and writes: the pixel's state (next triangle expected, triangles seen, violations) in the attachment, or in storage
// slot 0 by plain reads and writes.
layout(location = 0) in flat uint in_triangle;

uvec4 next_state(uvec4 state) {
  return uvec4(in_triangle + 1u, state.y + 1u, state.z + (state.x == in_triangle ? 0u : 1u), 0u);
}

#ifdef BUFFER
layout(constant_id = 0) const uint WIDTH = 256u;
layout(set = 0, binding = 1, std430) buffer States { uvec4 states[]; };
void main() {
  // Never taken. Without a discard lavapipe takes the triangle for opaque and drops whatever a tile that it covers had queued
  // before, storage writes and all; every pass that writes through buffers discards.
  if (in_triangle == 0xffffffffu) discard;
  uint pixel = uint(gl_FragCoord.y) * WIDTH + uint(gl_FragCoord.x);
  states[pixel] = next_state(states[pixel]);
}
#else
layout(input_attachment_index = 0, set = 0, binding = 24) uniform usubpassInput in_state;
layout(location = 0) out uvec4 out_state;
void main() { out_state = next_state(subpassLoad(in_state)); }
#endif
