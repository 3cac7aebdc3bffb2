// Push constants of the geometry passes. HullPush of replay/frontend/frontend.hpp.
#ifndef SUBPIXEL_HULL_INTERFACE_GLSL
#define SUBPIXEL_HULL_INTERFACE_GLSL

#include "include/frame.glsl"
#include "frontend/frontend_types.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 position[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Normals { vec3 normal[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvs { vec2 uv[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tangents { vec4 tangent[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Colours { vec4 colour[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ClipMatrices { mat4 clip_from_object[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord instance[]; };

layout(push_constant, scalar) uniform Push {
  Records records;
  Positions positions;
  Normals normals;
  Uvs uvs;
  Tangents tangents;
  Indices indices;
  ClipMatrices clip_matrices;
  Instances instances;
  Uvs second_uvs;
  Colours colours;
  uint material;      // of the batch being drawn
  uint triangle_slots;  // records of clipped pieces start here
#ifdef LISTED
  uint first_fragment, last_fragment;  // of the batch, by triangle
#endif
} push;

const uint kUvFeatures = FEATURE_BASE_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_ROUGHNESS_TEXTURE | FEATURE_EMISSIVE_TEXTURE;
// What fragments fetch from the source triangle's vertices themselves, so that hulls have no more outputs for it.
const uint kFetchedFeatures = FEATURE_SECOND_UV | FEATURE_VERTEX_COLOUR;

#endif
