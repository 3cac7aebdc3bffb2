// What the front-end sets up, by address, as the scene's streams are. Define WRITES_RECORDS where they are written.
// Reads: nothing; the addresses come with the including shader's push constants.
#ifndef SUBPIXEL_FRONTEND_BUFFERS_GLSL
#define SUBPIXEL_FRONTEND_BUFFERS_GLSL

#include "frontend/frontend_interface.h"
#include "scene/buffers.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ClipMatrices { mat4 clip_from_object[]; };
#ifdef WRITES_RECORDS
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Records { TriangleRecord record[]; };
#else
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Records { TriangleRecord record[]; };
#endif
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer HullIndices { uint index[]; };

#endif
