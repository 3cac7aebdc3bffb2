#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Fills the triangle buffer: a sample point within the triangle, and over it attributes / w and 1 / w as planes of the screen.
// One invocation for each stored triangle. Reads: its first word, a record; that; the source triangle's vertices.
// Writes: its words.
layout(local_size_x = 64) in;
#include "frontend/hull_interface.glsl"
#include "frontend/source_triangle.glsl"
#include "include/attributes.glsl"
#include "techniques/dais/triangles.glsl"

// Where the next scalar goes, and the corners' parts of value and changes.
uint place;
CornerAreas parts;

void store(TriangleWords words, vec3 corners) {
  words.word[place] = floatBitsToUint(dot(parts.value, corners));
  words.word[place + 1u] = floatBitsToUint(dot(parts.dx, corners));
  words.word[place + 2u] = floatBitsToUint(dot(parts.dy, corners));
  place += 3u;
}

float largest_of(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Of the snapped corner: 1 / w over what it is at the sample point.
float part_at(vec2 corner, vec2 point, vec2 slope) { return 1.0 + dot(slope, corner - point); }

void main() {
  uint triangle = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
  if (triangle >= push.last_fragment) return;
  TriangleWords words = triangles.words;
  uint first = triangle * kTriangleWords;
  TriangleRecord record = push.records.record[words.word[first]];
  const float snap = 1.0 / float(SUBPIXEL_SNAP);
  ivec2 band_corner = frame_pixel(ivec2(0)) * SUBPIXEL_SNAP;
  vec2 corner0 = vec2(ivec2(record.v01.xy) + band_corner) * snap, corner1 = vec2(ivec2(record.v01.zw) + band_corner) * snap,
       corner2 = vec2(ivec2(record.v2_ref.xy) + band_corner) * snap;
  vec2 point = (corner0 + corner1 + corner2) * (1.0 / 3.0);

  SourceTriangle source;
  uvec3 vertex = source_vertices(record.hull2_id.z);
  source_clip_uv(vertex, record.hull2_id.w, source);
  source_normals(vertex, record.hull2_id.w, record.v2_ref.w, source);
  CornerAreas areas = corner_areas(source.clip[0], source.clip[1], source.clip[2], point);
  float sum = areas.value.x + areas.value.y + areas.value.z;
  float inverse = sum != 0.0 ? 1.0 / sum : 0.0;
  parts = CornerAreas(areas.value * inverse, areas.dx * inverse, areas.dy * inverse);
  vec2 slope = vec2(dot(parts.dx, vec3(1.0)), dot(parts.dy, vec3(1.0)));
  // Changes of the weights themselves, at the sample point.
  vec3 steep = max(abs(parts.dx - parts.value * slope.x), abs(parts.dy - parts.value * slope.y));
  float least = min(part_at(corner0, point, slope), min(part_at(corner1, point, slope), part_at(corner2, point, slope)));
  // Said so that what is not a number fails as well.
  bool holds = sum != 0.0 && largest_of(steep) <= DAIS_STEEPEST && least >= DAIS_LEAST_PART &&
               largest_of(abs(parts.value)) <= 2.0;

  words.word[first] = holds ? floatBitsToUint(point.x) : DAIS_NO_PLANES;
  words.word[first + 1u] = floatBitsToUint(point.y);
  words.word[first + 2u] = floatBitsToUint(slope.x);
  words.word[first + 3u] = floatBitsToUint(slope.y);
  for (uint k = 0u; k < 4u; ++k) words.word[first + 4u + k] = record.depth[k];
  words.word[first + 8u] = record.depth2.x;
  words.word[first + 9u] = record.v2_ref.z;
  place = first + DAIS_HEAD_WORDS;
  for (uint k = 0u; k < 3u; ++k)
    store(words, vec3(source.normal[0][k], source.normal[1][k], source.normal[2][k]));
  if ((FEATURES & kUvFeatures) != 0u)
    for (uint k = 0u; k < 2u; ++k) store(words, vec3(source.uv[0][k], source.uv[1][k], source.uv[2][k]));
  if (has_feature(FEATURE_SECOND_UV)) {
    vec2 uv0 = push.second_uvs.uv[vertex.x], uv1 = push.second_uvs.uv[vertex.y], uv2 = push.second_uvs.uv[vertex.z];
    for (uint k = 0u; k < 2u; ++k) store(words, vec3(uv0[k], uv1[k], uv2[k]));
  }
  if (has_feature(FEATURE_VERTEX_COLOUR)) {
    vec4 c0 = push.colours.colour[vertex.x], c1 = push.colours.colour[vertex.y], c2 = push.colours.colour[vertex.z];
    for (uint k = 0u; k < 4u; ++k) store(words, vec3(c0[k], c1[k], c2[k]));
  }
  if (has_feature(FEATURE_NORMAL_MAP))
    for (uint k = 0u; k < 4u; ++k)
      store(words, vec3(source.tangent[0][k], source.tangent[1][k], source.tangent[2][k]));
}
