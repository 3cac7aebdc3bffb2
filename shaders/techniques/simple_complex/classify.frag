#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Tells the pixels whose samples agree from those that need shading per sample.
// Reads: visibility, G-buffer of full samples, triangle records.
// Writes: 1 for a complex pixel, else 0.
#include "deferred/stored_sample.glsl"
#include "include/visibility.glsl"
#include "frontend/buffers.glsl"
#include "techniques/simple_complex/simple_complex_interface.h"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(set = 0, binding = SAMPLED(SHADE_SLOT_GBUFFER)) uniform usampler2DArray gbuffer;
layout(push_constant, scalar) uniform Push { SimpleComplexClassifyPush push; };
layout(location = 0) out uint out_complex;

#include "techniques/simple_complex/classification.glsl"

uvec4 quad_triangles(uint quad) { return visible_triangles(ivec2(gl_FragCoord.xy), SAMPLES, quad); }
vec4 quad_depths(uint quad) { return uintBitsToFloat(visible_depths(ivec2(gl_FragCoord.xy), SAMPLES, quad)); }

ClassifiedSurface sample_surface(uint s) {
  uint triangle = quad_triangles(s / 4u)[s & 3u];
  uint material = push.records.record[triangle].v2_ref.w >> RECORD_MATERIAL_SHIFT;
  return ClassifiedSurface(unpack_normal(normal_of_stored(texelFetch(gbuffer, ivec3(gl_FragCoord.xy, s), 0))), material);
}

vec2 triangle_slopes(uint triangle) { return uintBitsToFloat(push.records.record[triangle].depth.yz); }

void main() { out_complex = pixel_is_complex(push.depth_scale, push.least_cosine) ? 1u : 0u; }
