// Where the passes over fragments find geometry and records: by address.
// Reads: push constants.
#ifndef SUBPIXEL_HULL_INTERFACE_GLSL
#define SUBPIXEL_HULL_INTERFACE_GLSL

#include "include/frame.glsl"
#include "frontend/frontend_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 position[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Normals { vec3 normal[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvs { vec2 uv[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tangents { vec4 tangent[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Colours { vec4 colour[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ClipMatrices { mat4 clip_from_object[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord instance[]; };

layout(push_constant, scalar) uniform Push { HullPush push; };

const uint kUvFeatures = FEATURE_BASE_TEXTURE | FEATURE_NORMAL_MAP | FEATURE_ROUGHNESS_TEXTURE | FEATURE_EMISSIVE_TEXTURE;
// What fragments fetch from the source triangle's vertices themselves, so that hulls have no more outputs for it.
const uint kFetchedFeatures = FEATURE_SECOND_UV | FEATURE_VERTEX_COLOUR;

#endif
