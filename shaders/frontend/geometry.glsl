// Where the front-end's passes find geometry and records: by address, since both may pass the size of a bound range.
// Reads: push constants; nothing else is declared here.
#ifndef SUBPIXEL_GEOMETRY_GLSL
#define SUBPIXEL_GEOMETRY_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 position[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ClipMatrices { mat4 clip_from_object[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord instance[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Records { TriangleRecord record[]; };

// FrontendPush of replay/frontend/frontend.cpp.
layout(push_constant, scalar) uniform Push {
  Positions positions;
  Indices indices;
  ClipMatrices clip_matrices;
  Instances instances;
  Records records;
  uint chunk_count;
  uint triangle_slots;  // records of clipped pieces start here
  uint piece_capacity;
} push;

void clip_positions(uint first_index, uint instance, out vec4 c[3]) {
  mat4 clip_from_object = push.clip_matrices.clip_from_object[instance];
  for (uint k = 0u; k < 3u; ++k) {
    vec3 p = push.positions.position[push.indices.index[first_index + k]];
    c[k] = clip_from_object * vec4(p, 1.0);
  }
}

bool instance_mirrored(uint instance) { return push.instances.instance[instance].normal_row[0].w < 0.0; }

#endif
