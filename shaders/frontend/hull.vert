#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: VISIBILITY= ALPHA=-DWITH_UV ATTRIBUTES=-DWITH_UV,-DWITH_ATTRIBUTES
// One corner of a triangle's conservative hull, which has three or four. What belongs to the triangle goes out flat and equal at all three corners,
// since a clipped hull may start at any of them.
// Reads: records; with ATTRIBUTES the source triangle's vertices. Writes: position and the flat outputs.
#include "include/frame.glsl"
#include "frontend/hull_interface.glsl"

layout(location = 0) out flat uvec4 out_v01;
layout(location = 1) out flat uvec4 out_v2_ref;
layout(location = 2) out flat uvec4 out_depth;
layout(location = 3) out flat uvec4 out_ids;
#ifdef WITH_UV
layout(location = 4) out flat vec3 out_clip0;
layout(location = 5) out flat vec3 out_clip1;
layout(location = 6) out flat vec3 out_clip2;
layout(location = 7) out flat vec4 out_uv01;
layout(location = 8) out flat vec2 out_uv2;
#endif
#ifdef WITH_ATTRIBUTES
layout(location = 9) out flat vec3 out_normal0;
layout(location = 10) out flat vec3 out_normal1;
layout(location = 11) out flat vec3 out_normal2;
layout(location = 12) out flat vec4 out_tangent0;
layout(location = 13) out flat vec4 out_tangent1;
layout(location = 14) out flat vec4 out_tangent2;
#endif

void main() {
  uint record = gl_VertexIndex / 4u, corner = gl_VertexIndex & 3u;
  uvec4 depth2 = push.records.record[record].depth2;
  uvec4 hull01 = push.records.record[record].hull01;
  uvec4 hull2_id = push.records.record[record].hull2_id;
  uvec4 v2_ref = push.records.record[record].v2_ref;
  uvec2 position = corner == 0u ? hull01.xy : corner == 1u ? hull01.zw : corner == 2u ? hull2_id.xy : depth2.yz;
  gl_Position = vec4(uintBitsToFloat(position) * frame.viewport.zw * 2.0 - 1.0, 0.5, 1.0);
  out_v01 = push.records.record[record].v01;
  out_v2_ref = v2_ref;
  out_depth = push.records.record[record].depth;
  out_ids = uvec4(depth2.x, record, depth2.w, 0u);
#ifdef WITH_UV
  mat4 clip_from_object = push.clip_matrices.clip_from_object[hull2_id.w];
  vec3 clip[3];
  vec2 uv[3];
  uvec3 vertex;
  for (uint k = 0u; k < 3u; ++k) {
    vertex[k] = push.indices.index[hull2_id.z + k];
    // x and y in pixels times w, as pixel positions are.
    vec4 c = clip_from_object * vec4(push.positions.position[vertex[k]], 1.0);
    clip[k] = vec3((c.xy + c.w) * 0.5 * frame.viewport.xy, c.w);
    uv[k] = (FEATURES & kUvFeatures) != 0u ? push.uvs.uv[vertex[k]] : vec2(0.0);
  }
  out_clip0 = clip[0];
  out_clip1 = clip[1];
  out_clip2 = clip[2];
  out_uv01 = vec4(uv[0], uv[1]);
  out_uv2 = uv[2];
#endif
#ifdef WITH_ATTRIBUTES
  // RECORD_BACK_FACE turns normals and tangents to the viewer's side here, once.
  InstanceRecord instance = push.instances.instance[hull2_id.w];
  float side = (v2_ref.w & RECORD_BACK_FACE) != 0u ? -1.0 : 1.0;
  vec3 normal[3];
  vec4 tangent[3];
  for (uint k = 0u; k < 3u; ++k) {
    vec3 n = push.normals.normal[vertex[k]];
    normal[k] = side * vec3(dot(instance.normal_row[0].xyz, n), dot(instance.normal_row[1].xyz, n),
                            dot(instance.normal_row[2].xyz, n));
    tangent[k] = vec4(0.0);
    if (has_feature(FEATURE_NORMAL_MAP)) {
      vec4 t = push.tangents.tangent[vertex[k]];
      float sign = (v2_ref.w & RECORD_MIRRORED) != 0u ? -t.w : t.w;
      tangent[k] = side * vec4(dot(instance.world_row[0].xyz, t.xyz), dot(instance.world_row[1].xyz, t.xyz),
                               dot(instance.world_row[2].xyz, t.xyz), sign);
    }
  }
  out_normal0 = normal[0];
  out_normal1 = normal[1];
  out_normal2 = normal[2];
  out_tangent0 = tangent[0];
  out_tangent1 = tangent[1];
  out_tangent2 = tangent[2];
#endif
}
