#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Lights each triangle that a pixel shows once: attributes are those of its planes in the triangle buffer, or of its vertices
// where it has none.
// Reads: listed fragments, the triangle buffer, materials, shadow map; records where edges decide the point, or without planes;
// then vertices, too. Writes: the fragments' values.
layout(local_size_x = 64) in;
#define WITH_UV
#define WITH_ATTRIBUTES
#include "frontend/listed_fragment.glsl"
#include "shade/lit_fragment.glsl"
#include "shade/listed_values.glsl"
#include "shade/shading_point.glsl"
#include "techniques/dais/planes.glsl"

void main() {
  uint number;
  if (!listed_number(number)) return;
  ListAddresses to = lists;
  TriangleBuffer from = triangles;
  uvec4 fragment = to.fragments.fragment[number];
  ivec2 pixel = listed_pixel(fragment);
  uint first;
  bool held = has_planes(from, number, first);
  if (POINT == SHADE_POINT_COVERED) load_record(fragment.x);
  vec2 offset = shading_point(pixel, fragment.zw);
  MaterialInputs inputs;
  DepthPlane depth;
  // Loops, so that groups of fragments that have planes skip the vertices.
  for (bool go = held; go; go = false) {
    inputs = plane_inputs(from.words, first, vec2(frame_pixel(pixel)) + 0.5 + offset);
    depth = stored_depth(from.words, first, pixel);
  }
  for (bool go = !held; go; go = false) {
    load_fragment(fragment.x);
    inputs = fragment_inputs(pixel, offset);
    depth = fragment_depth(pixel);
  }
  store_listed_value(to, number, lit_surface(material_surface(inputs), depth, pixel, offset), fragment.zw);
}
