#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The indirect draw of each batch (a run of chunks drawn together); one invocation for each batch.
// Reads: batches (first chunk, one past the last), scanned sums. Writes: VkDrawIndexedIndirectCommand.
layout(local_size_x = 64) in;
#include "frontend/frontend_interface.h"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_BATCHES), scalar) readonly buffer Batches { uvec2 batches[]; };
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_SUMS), scalar) readonly buffer Sums { uvec4 sums[]; };
struct DrawCommand {
  uint index_count, instance_count, first_index;
  int vertex_offset;
  uint first_instance;
};
layout(set = 0, binding = STORAGE(FRONTEND_SLOT_COMMANDS), scalar) writeonly buffer Commands { DrawCommand commands[]; };
layout(push_constant, scalar) uniform Push { DrawArgumentsPush push; };

void main() {
  uint batch = gl_GlobalInvocationID.x;
  if (batch >= push.batch_count) return;
  uint first = sums[batches[batch].x].x, last = sums[batches[batch].y].x;
  commands[batch] = DrawCommand(3u * (last - first), 1u, 3u * first, 0, 0u);
}
