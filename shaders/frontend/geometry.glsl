// Where the front-end's passes find geometry and records: by address, since both may pass the size of a bound range.
// Reads: push constants; nothing else is declared here.
#ifndef SUBPIXEL_GEOMETRY_GLSL
#define SUBPIXEL_GEOMETRY_GLSL

#define WRITES_RECORDS
#include "frontend/buffers.glsl"

layout(push_constant, scalar) uniform Push { SetupPush push; };

void clip_positions(uint first_index, uint instance, out vec4 c[3]) {
  mat4 clip_from_object = push.clip_matrices.clip_from_object[instance];
  for (uint k = 0u; k < 3u; ++k) {
    vec3 p = push.positions.position[push.indices.index[first_index + k]];
    c[k] = clip_from_object * vec4(p, 1.0);
  }
}

bool instance_mirrored(uint instance) { return push.instances.instance[instance].normal_row[0].w < 0.0; }

#endif
