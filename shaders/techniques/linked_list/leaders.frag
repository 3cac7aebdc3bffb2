#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// The fragments of each pixel that need a dynamic block.
// Reads: visibility. Writes: dynamic_leaders().
#define LINK_READS
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#define WRITES_LEADERS
#include "include/coverage.glsl"
#include "techniques/linked_list/leaders.glsl"

layout(location = 0) out uint out_leaders;

void main() { out_leaders = dynamic_leaders(pixel_triangles(pixel_of(gl_FragCoord.xy))); }
