// The vertices of a source triangle as fragments interpolate them.
// Reads: geometry by the push constants' addresses, frame constants. Needs hull_interface.glsl before it.
#ifndef SUBPIXEL_SOURCE_TRIANGLE_GLSL
#define SUBPIXEL_SOURCE_TRIANGLE_GLSL

struct SourceTriangle {
  vec3 clip[3];  // x and y in pixels times w, as pixel positions are; w
  vec2 uv[3];
  vec3 normal[3];  // world space, on the viewer's side
  vec4 tangent[3];
};

uvec3 source_vertices(uint first_index) {
  uvec3 vertex;
  for (uint k = 0u; k < 3u; ++k) vertex[k] = push.indices.index[first_index + k];
  return vertex;
}

void source_clip_uv(uvec3 vertex, uint instance, inout SourceTriangle t) {
  mat4 clip_from_object = push.clip_matrices.clip_from_object[instance];
  for (uint k = 0u; k < 3u; ++k) {
    vec4 c = clip_from_object * vec4(push.positions.position[vertex[k]], 1.0);
    t.clip[k] = vec3((c.xy + c.w) * 0.5 * frame.viewport.xy, c.w);
    t.uv[k] = (FEATURES & kUvFeatures) != 0u ? push.uvs.uv[vertex[k]] : vec2(0.0);
  }
}

// `flags`: of the record. RECORD_BACK_FACE turns normals and tangents to the viewer's side here, once.
void source_normals(uvec3 vertex, uint instance_number, uint flags, inout SourceTriangle t) {
  InstanceRecord instance = push.instances.instance[instance_number];
  float side = (flags & RECORD_BACK_FACE) != 0u ? -1.0 : 1.0;
  for (uint k = 0u; k < 3u; ++k) {
    vec3 n = push.normals.normal[vertex[k]];
    t.normal[k] = side * vec3(dot(instance.normal_row[0].xyz, n), dot(instance.normal_row[1].xyz, n),
                              dot(instance.normal_row[2].xyz, n));
    t.tangent[k] = vec4(0.0);
    if (has_feature(FEATURE_NORMAL_MAP)) {
      vec4 along = push.tangents.tangent[vertex[k]];
      float sign = (flags & RECORD_MIRRORED) != 0u ? -along.w : along.w;
      t.tangent[k] = side * vec4(dot(instance.world_row[0].xyz, along.xyz), dot(instance.world_row[1].xyz, along.xyz),
                                 dot(instance.world_row[2].xyz, along.xyz), sign);
    }
  }
}

#endif
