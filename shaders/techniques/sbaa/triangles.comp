#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The face normal and the depth slope of each triangle on the screen; one invocation for each.
// Reads: hull indices, triangle records, positions, indices, instances. Writes: at the record's number, the normal on the
// viewer's side (2 x 16 bits, octahedral) and the bits of |dz/dx| + |dz/dy|.
layout(local_size_x = 64) in;
#include "include/packing.glsl"
#include "frontend/buffers.glsl"
#include "techniques/sbaa/sbaa_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer Faces { uvec2 face[]; };
layout(push_constant, scalar) uniform Push { SbaaTrianglesPush push; };

void main() {
  uint hull = gl_GlobalInvocationID.y * push.row + gl_GlobalInvocationID.x;
  if (hull >= push.hull_triangles) return;
  uint record = push.hulls.index[3u * hull] / 4u;
  uvec4 hull2_id = push.records.record[record].hull2_id;
  uint flags = push.records.record[record].v2_ref.w;
  vec2 slopes = uintBitsToFloat(push.records.record[record].depth.yz);
  InstanceRecord instance = push.instances.instance[hull2_id.w];
  vec3 corner[3];
  for (uint k = 0u; k < 3u; ++k) corner[k] = push.positions.position[push.indices.index[hull2_id.z + k]];
  vec3 side[2];
  for (uint k = 0u; k < 2u; ++k) {
    vec3 along = corner[k + 1u] - corner[0];
    for (uint row = 0u; row < 3u; ++row) side[k][row] = dot(instance.world_row[row].xyz, along);
    side[k] *= inversesqrt(max(dot(side[k], side[k]), 1e-30));
  }
  vec3 normal = cross(side[0], side[1]);
  normal *= inversesqrt(max(dot(normal, normal), 1e-30));
  bool away = ((flags & RECORD_MIRRORED) != 0u) != ((flags & RECORD_BACK_FACE) != 0u);
  push.faces.face[record] = uvec2(pack_normal(away ? -normal : normal), floatBitsToUint(abs(slopes.x) + abs(slopes.y)));
}
