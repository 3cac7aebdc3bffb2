// A fragment: what the front-end gives every geometry pass for a triangle and a pixel.
// Reads: the flat outputs of hull.vert; with LISTED what listed_fragment.glsl loads. Define WITH_UV for textures, WITH_ATTRIBUTES
// for all vertex attributes.
#ifndef SUBPIXEL_FRAGMENT_GLSL
#define SUBPIXEL_FRAGMENT_GLSL

#include "frontend/hull_interface.glsl"
#include "frontend/source_triangle.glsl"
#include "include/coverage.glsl"
#include "include/attributes.glsl"
#include "include/material.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
layout(constant_id = CONSTANT_ALPHA_MODE) const uint ALPHA_MODE = ALPHA_MODE_TO_COVERAGE;

layout(set = 0, binding = STORAGE(FRAME_SLOT_MATERIALS), scalar) readonly buffer Materials { MaterialRecord materials[]; };

#ifdef LISTED
#define FLAT_INPUT(place, type, name) type name;
#else
#define FLAT_INPUT(place, type, name) layout(location = place) in flat type name;
#endif
FLAT_INPUT(0, uvec4, in_v01)
FLAT_INPUT(1, uvec4, in_v2_ref)
FLAT_INPUT(2, uvec4, in_depth)
FLAT_INPUT(3, uvec4, in_ids)
#ifdef WITH_UV
FLAT_INPUT(4, vec3, in_clip0)
FLAT_INPUT(5, vec3, in_clip1)
FLAT_INPUT(6, vec3, in_clip2)
FLAT_INPUT(7, vec4, in_uv01)
FLAT_INPUT(8, vec2, in_uv2)
#endif
#ifdef WITH_ATTRIBUTES
FLAT_INPUT(9, vec3, in_normal0)
FLAT_INPUT(10, vec3, in_normal1)
FLAT_INPUT(11, vec3, in_normal2)
FLAT_INPUT(12, vec4, in_tangent0)
FLAT_INPUT(13, vec4, in_tangent1)
FLAT_INPUT(14, vec4, in_tangent2)
#endif

uint fragment_triangle() { return in_ids.y; }
uint fragment_slot() { return in_ids.z; }  // in submission order, unlike the records of clipped pieces

PixelEdges fragment_edges(ivec2 pixel) {
  return pixel_edges(ivec2(in_v01.xy), ivec2(in_v01.zw), ivec2(in_v2_ref.xy), pixel,
                     in_v2_ref.w);
}

DepthPlane fragment_depth(ivec2 pixel) {
  return depth_plane(in_depth, in_ids.x, reference_pixel(in_v2_ref.z), pixel);
}

// Where attributes are evaluated, relative to the pixel's centre in pixels: the centre when the triangle covers it, else the
// centroid of the covered samples.
vec2 shading_offset(PixelEdges edges, uint n) {
  if (n == 1u) return vec2(0.0);
  vec2 sum = vec2(0.0);
  float count = 0.0;
  bool centre = covers(edges, ivec2(0));
  // Loops, so that groups of pixels that the triangle covers skip the search for a centroid.
  for (bool go = !centre && !edges.large; go; go = false) {
    for (uint i = 0u; i < n; ++i) {
      ivec2 offset = sample_offset(n, i);
      float weight = small_covers(edges, offset) ? 1.0 : 0.0;
      sum += weight * vec2(offset);
      count += weight;
    }
  }
  for (bool go = !centre && edges.large; go; go = false) {
    for (uint i = 0u; i < n; ++i) {
      ivec2 offset = sample_offset(n, i);
      float weight = large_covers(edges, offset) ? 1.0 : 0.0;
      sum += weight * vec2(offset);
      count += weight;
    }
  }
  return centre ? vec2(0.0) : sum / (max(count, 1.0) * float(SUBPIXEL_SAMPLE_GRID));
}

#ifdef WITH_UV
Weights fragment_weights(ivec2 pixel, vec2 offset) {
  return interpolation_weights(in_clip0, in_clip1, in_clip2, vec2(frame_pixel(pixel)) + 0.5 + offset);
}

vec2 fragment_uv(vec3 weight) { return interpolate(weight, in_uv01.xy, in_uv01.zw, in_uv2); }

vec2 fragment_second_uv(vec3 weight) {
  uvec3 vertex = source_vertices(in_ids.w);
  return interpolate(weight, push.second_uvs.uv[vertex.x], push.second_uvs.uv[vertex.y], push.second_uvs.uv[vertex.z]);
}

vec4 fragment_colour(vec3 weight) {
  uvec3 vertex = source_vertices(in_ids.w);
  return interpolate(weight, push.colours.colour[vertex.x], push.colours.colour[vertex.y],
                     push.colours.colour[vertex.z]);
}

VertexInputs vertex_inputs(Weights w) {
  VertexInputs v;
  v.first = TextureCoordinates(fragment_uv(w.value), fragment_uv(w.dx), fragment_uv(w.dy));
  v.second = TextureCoordinates(vec2(0.0), vec2(0.0), vec2(0.0));
  if (has_feature(FEATURE_SECOND_UV))
    v.second = TextureCoordinates(fragment_second_uv(w.value), fragment_second_uv(w.dx), fragment_second_uv(w.dy));
  v.colour = vec4(1.0);
  if (has_feature(FEATURE_VERTEX_COLOUR)) v.colour = fragment_colour(w.value);
  return v;
}

// Rank of sample i of n in a fixed order that spreads over the pixel: which samples a translucent fragment covers first.
uint coverage_rank(uint i) {
  return (i * 5u + 3u) % SAMPLES;
}

// The samples of `mask` (samples [first, first + count)) that the material's alpha leaves.
// to_coverage: alpha and its screen derivatives, measured by three texture reads, give a plane whose values at the samples are
// compared with the cutoff; a blended material covers as many samples as its alpha says. test: one decision at the shading
// point. per_sample: a texture read for every sample.
uint alpha_mask(uint mask, uint first, uint count, ivec2 pixel, vec2 offset) {
  MaterialRecord m = materials[push.material];
  float cutoff = m.emissive_cutoff.w;
  bool blend = (m.flags.x & MATERIAL_ALPHA_BLEND) != 0u;
  Weights w = fragment_weights(pixel, offset);
  VertexInputs v = vertex_inputs(w);
  TextureCoordinates c = coordinates_of(m, 0u, v);
  vec2 uv = c.uv, dx = c.dx, dy = c.dy;
  // The vertices' part, at the shading point and its change per pixel in x and y.
  vec3 vertex_alpha = vec3(1.0, 0.0, 0.0);
  if (has_feature(FEATURE_VERTEX_COLOUR))
    vertex_alpha = vec3(v.colour.a, fragment_colour(w.dx).a, fragment_colour(w.dy).a);
  float alpha = material_alpha(m, uv, dx, dy);
  if (has_feature(FEATURE_VERTEX_COLOUR)) alpha *= vertex_alpha.x;
  if (ALPHA_MODE == ALPHA_MODE_TEST) return alpha >= (blend ? 0.5 : cutoff) ? mask : 0u;
  uint left = 0u;
  if (ALPHA_MODE == ALPHA_MODE_PER_SAMPLE) {
    for (uint i = 0u; i < count; ++i) {
      vec2 at = vec2(sample_offset(SAMPLES, first + i)) * (1.0 / 128.0) - offset;
      float a = material_alpha(m, uv + dx * at.x + dy * at.y, dx, dy);
      if (has_feature(FEATURE_VERTEX_COLOUR)) a *= dot(vertex_alpha, vec3(1.0, at));
      float threshold = blend ? (float(coverage_rank(first + i)) + 0.5) / float(SAMPLES) : cutoff;
      left |= a >= threshold ? 1u << i : 0u;
    }
    return mask & left;
  }
  float step_x = material_alpha(m, uv + dx * 0.5, dx, dy), step_y = material_alpha(m, uv + dy * 0.5, dx, dy);
  if (has_feature(FEATURE_VERTEX_COLOUR)) {
    step_x *= vertex_alpha.x + 0.5 * vertex_alpha.y;
    step_y *= vertex_alpha.x + 0.5 * vertex_alpha.z;
  }
  vec2 slope = 2.0 * (vec2(step_x, step_y) - alpha);
  for (uint i = 0u; i < count; ++i) {
    vec2 at = vec2(sample_offset(SAMPLES, first + i)) * (1.0 / 128.0) - offset;
    float threshold = blend ? (float(coverage_rank(first + i)) + 0.5) / float(SAMPLES) : cutoff;
    left |= alpha + (blend ? 0.0 : dot(slope, at)) >= threshold ? 1u << i : 0u;
  }
  return mask & left;
}
#endif

#ifdef WITH_ATTRIBUTES
// What a material takes from the triangle at one point of it.
struct MaterialInputs {
  VertexInputs vertex;
  vec3 normal;   // world space, unit, on the viewer's side
  vec4 tangent;  // 0 unless some material has a normal map
};

vec3 unit_normal(vec3 interpolated) {
  return interpolated * inversesqrt(max(dot(interpolated, interpolated), 1e-20));
}

MaterialInputs fragment_inputs(ivec2 pixel, vec2 offset) {
  Weights w = fragment_weights(pixel, offset);
  MaterialInputs inputs;
  inputs.normal = unit_normal(interpolate(w.value, in_normal0, in_normal1, in_normal2));
  inputs.tangent = has_feature(FEATURE_NORMAL_MAP) ? interpolate(w.value, in_tangent0, in_tangent1, in_tangent2) : vec4(0.0);
  inputs.vertex = vertex_inputs(w);
  return inputs;
}

// The material's surface there; all but the position.
Surface material_surface(MaterialInputs inputs) {
  Surface s;
  s.position = vec3(0.0);
  evaluate_material(materials[push.material], inputs.vertex, inputs.normal, inputs.tangent, s);
  return s;
}

// At the shading point.
Surface fragment_surface(ivec2 pixel, vec2 offset) { return material_surface(fragment_inputs(pixel, offset)); }
#endif
#endif
