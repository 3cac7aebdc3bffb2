#version 460
// Counts the triangles of a pixel and those that don't follow their predecessor.
// Reads and writes: the attachment (next triangle expected, triangles seen, violations).
layout(input_attachment_index = 0, set = 0, binding = 24) uniform usubpassInput in_state;
layout(location = 0) in flat uint in_triangle;
layout(location = 0) out uvec4 out_state;
void main() {
  uvec4 state = subpassLoad(in_state);
  out_state = uvec4(in_triangle + 1u, state.y + 1u, state.z + (state.x == in_triangle ? 0u : 1u), 0u);
}
