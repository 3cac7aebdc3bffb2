// A fragment from the lists, for compute passes over the fragments of one material: after load_fragment() all that
// fragment.glsl has is there as in a fragment shader.
// Reads: push constants, fragments, records; with WITH_UV and WITH_ATTRIBUTES the source triangle's vertices.
#ifndef SUBPIXEL_LISTED_FRAGMENT_GLSL
#define SUBPIXEL_LISTED_FRAGMENT_GLSL

#ifndef LISTED
#define LISTED
#endif
#include "frontend/fragment.glsl"
#include "frontend/fragment_lists.glsl"

layout(set = 0, binding = STORAGE(FRONTEND_SLOT_LISTS), scalar) readonly buffer Lists { ListAddresses lists; };

bool listed_number(out uint number) {
  number = push.first_fragment + gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  return number < push.last_fragment;
}

ivec2 listed_pixel(uvec4 fragment) { return ivec2(fragment.y & 0xffffu, fragment.y >> 16); }

// What fragment.glsl needs for edges and depth.
void load_record(uint record) {
  uvec4 depth2 = push.records.record[record].depth2;
  in_v01 = push.records.record[record].v01;
  in_v2_ref = push.records.record[record].v2_ref;
  in_depth = push.records.record[record].depth;
  in_ids = uvec4(depth2.x, record, depth2.w, 0u);
}

#ifdef WITH_UV
// What it needs for attributes; after load_record().
void load_vertices(uint record) {
  SourceTriangle source;
  uint first_index = push.records.record[record].hull2_id.z;
  if (has_feature(kFetchedFeatures)) in_ids.w = first_index;
  uvec3 vertex = source_vertices(first_index);
  uint instance = push.records.record[record].hull2_id.w;
  source_clip_uv(vertex, instance, source);
  in_clip0 = source.clip[0];
  in_clip1 = source.clip[1];
  in_clip2 = source.clip[2];
  in_uv01 = vec4(source.uv[0], source.uv[1]);
  in_uv2 = source.uv[2];
#ifdef WITH_ATTRIBUTES
  source_normals(vertex, instance, in_v2_ref.w, source);
  in_normal0 = source.normal[0];
  in_normal1 = source.normal[1];
  in_normal2 = source.normal[2];
  in_tangent0 = source.tangent[0];
  in_tangent1 = source.tangent[1];
  in_tangent2 = source.tangent[2];
#endif
}
#endif

void load_fragment(uint record) {
  load_record(record);
#ifdef WITH_UV
  load_vertices(record);
#endif
}

#endif
