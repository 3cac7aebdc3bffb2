#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Lights each triangle that a pixel shows once: its vertices are fetched by the triangle's number and interpolated.
// Reads: listed fragments, records, the source triangles' vertices, materials, shadow map. Writes: the fragments' values.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "shade/lit_fragment.glsl"
#include "shade/listed_values.glsl"
#include "shade/shading_point.glsl"

void main() {
  uint number;
  if (!listed_number(number)) return;
  ListAddresses to = lists;
  uvec4 fragment = to.fragments.fragment[number];
  load_fragment(fragment.x);
  ivec2 pixel = listed_pixel(fragment);
  store_listed_value(to, number, lit_fragment(pixel, shading_point(pixel, fragment.zw)), fragment.zw);
}
