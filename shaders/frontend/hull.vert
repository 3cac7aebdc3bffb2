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
#include "frontend/source_triangle.glsl"

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
  out_ids = uvec4(depth2.x, record, depth2.w, has_feature(kFetchedFeatures) ? hull2_id.z : 0u);
#ifdef WITH_UV
  SourceTriangle source;
  uvec3 vertex = source_vertices(hull2_id.z);
  source_clip_uv(vertex, hull2_id.w, source);
  out_clip0 = source.clip[0];
  out_clip1 = source.clip[1];
  out_clip2 = source.clip[2];
  out_uv01 = vec4(source.uv[0], source.uv[1]);
  out_uv2 = source.uv[2];
#endif
#ifdef WITH_ATTRIBUTES
  source_normals(vertex, hull2_id.w, v2_ref.w, source);
  out_normal0 = source.normal[0];
  out_normal1 = source.normal[1];
  out_normal2 = source.normal[2];
  out_tangent0 = source.tangent[0];
  out_tangent1 = source.tangent[1];
  out_tangent2 = source.tangent[2];
#endif
}
