// The reference's triangles: where they are, what their attributes are at a point of the screen.
// Reads: the push constants' buffers by address.
#ifndef SUBPIXEL_REFERENCE_TRIANGLES_GLSL
#define SUBPIXEL_REFERENCE_TRIANGLES_GLSL

#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "include/frame.glsl"
#include "include/shared_types.h"
#include "reference/reference_interface.h"

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Corners { vec4 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Triangles { ReferenceTriangle at[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vectors2 { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vectors3 { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vectors4 { vec4 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) buffer Pixels { vec4 at[]; };

layout(push_constant, scalar) uniform Push { ReferencePush push; };

layout(set = 0, binding = STORAGE(REFERENCE_SLOT_TURN), std430) readonly buffer Turn { TurnConstants turn; };
layout(set = 0, binding = STORAGE(FRAME_SLOT_MATERIALS), std430) readonly buffer Materials { MaterialRecord materials[]; };
layout(set = 0, binding = STORAGE(REFERENCE_SLOT_LEVELS), std430) readonly buffer Levels { TextureLevel levels[]; };
layout(set = 0, binding = STORAGE(REFERENCE_SLOT_MATERIAL_TEXTURES), std430) readonly buffer MaterialTextures { uvec4 material_textures[]; };
layout(set = 0, binding = STORAGE(FRAME_SLOT_UV_MAPPINGS), std430) readonly buffer UvMappings { UvMappingRecord uv_mappings[]; };

layout(constant_id = REFERENCE_CONSTANT_SIDE) const uint SIDE = 2u;
const uint SAMPLES_OF_TURN = SIDE * SIDE;

// Samples 0 1 over 2 3 of a pixel's quarter, quarters 0 1 over 2 3 likewise (Morton's order).
uvec2 cell_of(uint s) { return uvec2((s & 1u) | (s >> 1 & 2u), (s >> 1 & 1u) | (s >> 2 & 2u)); }
uint sample_of(uvec2 cell) { return (cell.x & 1u) | (cell.y & 1u) << 1 | (cell.x & 2u) << 1 | (cell.y & 2u) << 2; }

// Where sample `s` of this turn lies in its pixel, somewhere in its cell.
vec2 sample_place(uint s) { return (vec2(cell_of(s)) + 0.5) / float(SIDE) - turn.shift.xy; }

// Perspective-correct weights of a triangle's corners at a point, and the corners relative to it.
struct Weights {
  vec3 value;       // not negative, sum 1
  vec3 dx, dy;      // change per pixel
  float depth;      // at the point
};

// `point` in pixels. The weights are ratios of determinants of homogeneous corners, moved so that the point is the
// origin, which keeps small triangles exact and needs no clipping (Olano and Greer 1997).
Weights weights_at(uint triangle, vec2 point) {
  vec4 p0 = push.corners.at[3u * triangle], p1 = push.corners.at[3u * triangle + 1u], p2 = push.corners.at[3u * triangle + 2u];
  vec2 ndc = point * frame.viewport.zw * 2.0 - 1.0;
  vec2 a = p0.xy - ndc * p0.w, b = p1.xy - ndc * p1.w, c = p2.xy - ndc * p2.w;
  vec3 raw = vec3(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
  float sum = raw.x + raw.y + raw.z;
  float inverse = abs(sum) > 1e-37 ? 1.0 / sum : 0.0;
  vec3 value = max(raw * inverse, 0.0);
  float total = value.x + value.y + value.z;
  Weights w;
  w.value = total > 0.0 && total < 1e30 ? value / total : vec3(1.0 / 3.0);
  // Moving the point by one unit of ndc changes a by -p0.w in that direction, and so on.
  vec3 raw_dx = vec3(b.y * p2.w - p1.w * c.y, c.y * p0.w - p2.w * a.y, a.y * p1.w - p0.w * b.y);
  vec3 raw_dy = vec3(p1.w * c.x - b.x * p2.w, p2.w * a.x - c.x * p0.w, p0.w * b.x - a.x * p1.w);
  vec2 per_pixel = 2.0 * frame.viewport.zw * inverse;
  w.dx = (raw_dx - w.value * (raw_dx.x + raw_dx.y + raw_dx.z)) * per_pixel.x;
  w.dy = (raw_dy - w.value * (raw_dy.x + raw_dy.y + raw_dy.z)) * per_pixel.y;
  float clip_w = dot(w.value, vec3(p0.w, p1.w, p2.w));
  w.depth = clip_w > 0.0 ? clamp(dot(w.value, vec3(p0.z, p1.z, p2.z)) / clip_w, 0.0, 1.0) : 1.0;
  return w;
}

// Texture coordinates at a point, and their change per pixel.
struct Coordinates {
  vec2 uv, dx, dy;
};

Coordinates interpolated(vec2 a, vec2 b, vec2 c, Weights w) {
  Coordinates result;
  result.uv = w.value.x * a + w.value.y * b + w.value.z * c;
  result.dx = w.dx.x * a + w.dx.y * b + w.dx.z * c;
  result.dy = w.dy.x * a + w.dy.y * b + w.dy.z * c;
  return result;
}

// Where texture `which` of material `material` (its number in material_textures) is read.
Coordinates coordinates_of(uvec3 vertex, Weights w, uint material, uint which) {
  Coordinates c = interpolated(push.uvs.at[vertex.x], push.uvs.at[vertex.y], push.uvs.at[vertex.z], w);
  if (has_feature(FEATURE_SECOND_UV)) {
    Coordinates second = interpolated(push.second_uvs.at[vertex.x], push.second_uvs.at[vertex.y], push.second_uvs.at[vertex.z], w);
    if ((materials[material].flags.x & (MATERIAL_SECOND_UV << which)) != 0u) c = second;
  }
  if (has_feature(FEATURE_TEXTURE_TRANSFORM)) {
    UvMappingRecord mapping = uv_mappings[materials[material].flags.y + which];
    mat2 linear = transpose(mat2(mapping.row[0].xy, mapping.row[1].xy));
    c.uv = linear * c.uv + vec2(mapping.row[0].z, mapping.row[1].z);
    c.dx = linear * c.dx;
    c.dy = linear * c.dy;
  }
  return c;
}

vec4 colour_of(uvec3 vertex, Weights w) {
  return w.value.x * push.colours.at[vertex.x] + w.value.y * push.colours.at[vertex.y] + w.value.z * push.colours.at[vertex.z];
}

uvec3 vertices_of(ReferenceTriangle t) {
  uint first = t.source.x;
  return uvec3(push.indices.at[first], push.indices.at[first + 1u], push.indices.at[first + 2u]);
}

#endif
