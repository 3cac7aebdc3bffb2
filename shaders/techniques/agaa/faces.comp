#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The face normal of each triangle on the screen, on the viewer's side, rounded as two bytes a sample would; one invocation for
// each triangle.
// Reads: hull indices, triangle records, positions, indices, instances, frame constants.
// Writes: at the record's number, the rounded normal in view space with z towards the eye, packed as in packing.glsl.
layout(local_size_x = 64) in;
#include "techniques/agaa/agaa_interface.h"
#include "include/packing.glsl"
#include "techniques/agaa/face_normal.glsl"

layout(constant_id = AGAA_CONSTANT_OPTIONS) const uint AGAA_OPTIONS = 0u;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Hulls { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 position[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord instance[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Faces { uint face[]; };
layout(push_constant, scalar) uniform Push { AgaaFacesPush push; };

void main() {
  uint hull = gl_GlobalInvocationID.y * push.row + gl_GlobalInvocationID.x;
  if (hull >= push.hull_triangles) return;
  uint record = push.hulls.index[3u * hull] / 4u;
  uvec4 source = push.records.record[record].hull2_id;
  uint flags = push.records.record[record].v2_ref.w;
  InstanceRecord instance = push.instances.instance[source.w];
  vec3 corner[3];
  for (uint k = 0u; k < 3u; ++k) corner[k] = push.positions.position[push.indices.index[source.z + k]];
  // Edges of unit length, so that neither tiny nor huge triangles leave the range of floats.
  vec3 edge[2];
  for (uint k = 0u; k < 2u; ++k) {
    vec3 along = corner[k + 1u] - corner[0];
    for (uint row = 0u; row < 3u; ++row) edge[k][row] = dot(instance.world_row[row].xyz, along);
    edge[k] *= inversesqrt(max(dot(edge[k], edge[k]), 1e-30));
  }
  vec3 normal = mat3(frame.view) * cross(edge[0], edge[1]);
  bool away = ((flags & RECORD_MIRRORED) != 0u) != ((flags & RECORD_BACK_FACE) != 0u);
  normal *= (away ? -1.0 : 1.0) * inversesqrt(max(dot(normal, normal), 1e-30));
  if ((AGAA_OPTIONS & AGAA_DISTANCE_ALONG_VIEW) != 0u) normal.z = -normal.z;
  push.faces.face[record] = pack_normal(decoded_face(face_code(normal, push.largest_polar), push.largest_polar));
}
