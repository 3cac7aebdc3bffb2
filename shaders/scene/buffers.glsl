// The scene's vertex streams, indices and instances, by address, since they may pass the size of a bound range.
// Reads: nothing; the addresses come with the including shader's push constants.
#ifndef SUBPIXEL_SCENE_BUFFERS_GLSL
#define SUBPIXEL_SCENE_BUFFERS_GLSL

#include "include/shared_types.h"
#include "scene/scene_interface.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Positions { vec3 position[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Normals { vec3 normal[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Uvs { vec2 uv[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tangents { vec4 tangent[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Colours { vec4 colour[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Indices { uint index[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Instances { InstanceRecord instance[]; };

#endif
