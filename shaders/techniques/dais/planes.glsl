// Attributes and depth of a stored triangle at a point of the screen.
// Reads: the triangle buffer. Needs fragment.glsl with WITH_ATTRIBUTES.
#ifndef SUBPIXEL_DAIS_PLANES_GLSL
#define SUBPIXEL_DAIS_PLANES_GLSL

#include "techniques/dais/triangles.glsl"

// A stored triangle seen from a point: attribute = (value + changes * away) * inverse, and its own changes per pixel follow.
struct PlanePoint {
  uint place;  // of the next scalar
  vec2 away;   // pixels from the sample point
  vec2 slope;  // of 1 / w
  float inverse;
};

PlanePoint plane_point(TriangleWords words, uint first, vec2 position) {
  PlanePoint p;
  p.place = first + DAIS_HEAD_WORDS;
  p.away = position - vec2(uintBitsToFloat(words.word[first]), uintBitsToFloat(words.word[first + 1u]));
  p.slope = vec2(uintBitsToFloat(words.word[first + 2u]), uintBitsToFloat(words.word[first + 3u]));
  // At least what its corners have (DAIS_LEAST_PART); a place beyond an edge by a rounding has hardly less.
  p.inverse = 1.0 / max(1.0 + dot(p.slope, p.away), 0.5 * DAIS_LEAST_PART);
  return p;
}

// The next scalar: its value, and its change per pixel in x and y.
vec3 next_scalar(TriangleWords words, inout PlanePoint p) {
  vec2 change = vec2(uintBitsToFloat(words.word[p.place + 1u]), uintBitsToFloat(words.word[p.place + 2u]));
  float value = (uintBitsToFloat(words.word[p.place]) + dot(change, p.away)) * p.inverse;
  p.place += 3u;
  return vec3(value, (change - value * p.slope) * p.inverse);
}

TextureCoordinates next_coordinates(TriangleWords words, inout PlanePoint p) {
  vec3 u = next_scalar(words, p), v = next_scalar(words, p);
  return TextureCoordinates(vec2(u.x, v.x), vec2(u.y, v.y), vec2(u.z, v.z));
}

vec3 next_vector(TriangleWords words, inout PlanePoint p) {
  vec3 v;
  for (uint k = 0u; k < 3u; ++k) v[k] = next_scalar(words, p).x;
  return v;
}

MaterialInputs plane_inputs(TriangleWords words, uint first, vec2 position) {
  PlanePoint p = plane_point(words, first, position);
  TextureCoordinates none = TextureCoordinates(vec2(0.0), vec2(0.0), vec2(0.0));
  MaterialInputs inputs = MaterialInputs(VertexInputs(none, none, vec4(1.0)), vec3(0.0), vec4(0.0));
  inputs.normal = unit_normal(next_vector(words, p));
  if ((FEATURES & kUvFeatures) != 0u) inputs.vertex.first = next_coordinates(words, p);
  if (has_feature(FEATURE_SECOND_UV)) inputs.vertex.second = next_coordinates(words, p);
  if (has_feature(FEATURE_VERTEX_COLOUR)) inputs.vertex.colour = vec4(next_vector(words, p), next_scalar(words, p).x);
  if (has_feature(FEATURE_NORMAL_MAP)) inputs.tangent = vec4(next_vector(words, p), next_scalar(words, p).x);
  return inputs;
}

DepthPlane stored_depth(TriangleWords words, uint first, ivec2 pixel) {
  uvec4 depth = uvec4(words.word[first + 4u], words.word[first + 5u], words.word[first + 6u], words.word[first + 7u]);
  return depth_plane(depth, words.word[first + 8u], reference_pixel(words.word[first + 9u]), pixel);
}

#endif
