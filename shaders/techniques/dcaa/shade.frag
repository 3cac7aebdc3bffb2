#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: IMAGE=-DIMAGE BUFFER= IMAGE_LOBES=-DIMAGE,-DLOBES BUFFER_LOBES=-DLOBES STORY=-DSTORY STORY_LOBES=-DSTORY,-DLOBES
// Final depth resolve (Wang et al. 2015, section 3.4): the nearest plane at each sample, one lighting execution for each
// surface that any sample shows, weights n_i / N; samples that nothing covers show the sky.
// Reads: the pixel's state, the camera, shadow map. Writes: linear radiance with the lighting executions in
// a; display values.
#include "techniques/dcaa/dcaa_interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 64u;
#ifdef LOBES
#include "techniques/agaa/shading.glsl"
#else
#include "include/lights.glsl"
#endif
#include "include/resolve.glsl"
#include "techniques/dcaa/surface.glsl"
#include "techniques/dcaa/coverage.glsl"
#include "techniques/dcaa/depth_bound.glsl"
#include "techniques/dcaa/merge.glsl"
#include "techniques/dcaa/state.glsl"
#include "techniques/dcaa/state_read.glsl"
#include "story/lighting.glsl"

// Surfaces that show fewer samples are lit as part of the nearest.
layout(constant_id = DCAA_CONSTANT_LEAST_SHOWN) const uint LEAST_SHOWN = 0u;

layout(set = 0, binding = STORAGE(DCAA_SLOT_VIEW), scalar) readonly buffer ViewBlock { DcaaView view; };
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

// Samples at which the plane of a difference of depths is above 0, or 0 if `at_zero`. Written out, since drivers unroll
// loops up to a size only.
uvec2 samples_ahead(vec3 difference, bool at_zero) {
  uvec2 samples = uvec2(0u);
#define AHEAD(i)                                                                                                     \
  {                                                                                                                  \
    vec2 offset = vec2(sample_offset(SAMPLES, (i) % SAMPLES)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));                 \
    float d = difference.x + difference.y * offset.x + difference.z * offset.y;                                      \
    samples[(i) >> 5] |= d > 0.0 || (at_zero && d == 0.0) ? 1u << ((i) & 31u) : 0u;                                  \
  }
#define AHEAD_8(i) \
  AHEAD(i) AHEAD(i + 1u) AHEAD(i + 2u) AHEAD(i + 3u) AHEAD(i + 4u) AHEAD(i + 5u) AHEAD(i + 6u) AHEAD(i + 7u)
  AHEAD_8(0u) AHEAD_8(8u)
  if (SAMPLES > 16u) { AHEAD_8(16u) AHEAD_8(24u) }
  if (SAMPLES > 32u) { AHEAD_8(32u) AHEAD_8(40u) AHEAD_8(48u) AHEAD_8(56u) }
  return samples;
}

vec3 place_at(vec2 offset, float depth, vec2 slope) {
  return world_position(vec2(frame_pixel(pixel_of(gl_FragCoord.xy))) + 0.5 + offset, clamp(depth + dot(slope, offset), 0.0, 1.0));
}

// Radiance of surface `s`, lit at the centroid of `samples`.
vec3 radiance_of(DcaaSurface s, vec2 slope, uvec2 samples) {
  vec2 offset = vec2(0.0);
  for (bool part = samples != kWholePixel; part; part = false) offset = mask_centroid(samples);
  Surface lit = unpack_surface(uvec4(s.albedo, s.normal, s.roughness | 255u << 8, s.emission));
  lit.position = place_at(offset, s.depth, slope);
  vec3 view_direction = normalize(frame.eye.xyz - lit.position);
#ifdef LOBES
  Aggregate a;
  a.normal = dcaa_shading(s.normal);
  a.diffuse = lit.albedo * (1.0 - lit.metallic);
  a.reflectance = mix(vec3(kDielectricReflectance), lit.albedo, lit.metallic);
  a.roughness = lit.roughness;
  a.emissive = lit.emissive;
  dcaa_moments(s.moments, a.moments, a.mixed_moments);
  a.mask = 0u;
  // A square on the surface's plane with as much area as the samples: a side has the variance of an even distribution, a twelfth
  // of its square.
  float deviation = sqrt(float(int(dcaa_count(samples))) * (1.0 / (12.0 * float(SAMPLES))));
  Footprint footprint;
  footprint.mean = lit.position;
  footprint.axis = vec3[3](place_at(offset + vec2(deviation, 0.0), s.depth, slope) - lit.position,
                           place_at(offset + vec2(0.0, deviation), s.depth, slope) - lit.position, vec3(0.0));
  return shade_aggregate(a, footprint, view_direction);
#else
  return shade(lit, view_direction);
#endif
}

// Where more than two surfaces show, what shows of each that shows too little joins the nearest other that shows, which
// keeps its plane; attributes are averaged by the samples that show.
void fold(inout DcaaSurface surface[DCAA_MAX_SURFACES], inout uvec2 shown[DCAA_MAX_SURFACES], vec3 ray) {
  uint small = 0u, showing = 0u;
  for (uint i = 0u; i < SURFACES; ++i) {
    uint own = dcaa_count(shown[i]);
    showing += own > 0u ? 1u : 0u;
    small |= own > 0u && own < LEAST_SHOWN ? 1u << i : 0u;
  }
  small = showing > 2u ? small : 0u;
  while (small != 0u) {
    uint which = uint(findLSB(small));
    small &= small - 1u;
    DcaaSurface part = surface[0];
    part.coverage = shown[0];
    for (uint i = 1u; i < SURFACES; ++i) {
      part = dcaa_select(which == i, surface[i], part);
      part.coverage = which == i ? shown[i] : part.coverage;
    }
    vec3 normal = dcaa_facet(part.facet), joined_normal = normal;
    float place = dcaa_place(part.depth, ray, view), least = 1e38;
    uint nearest = SURFACES;
    DcaaSurface joined = part;
    for (uint i = 0u; i < SURFACES; ++i) {
      float there = dcaa_place(surface[i].depth, ray, view);
      vec3 other = dcaa_facet(surface[i].facet);
      float away = dcaa_distance(there, other, place, normal);
      bool better = i != which && shown[i] != uvec2(0u) && away < least;
      least = better ? away : least;
      nearest = better ? i : nearest;
      joined = dcaa_select(better, surface[i], joined);
      joined_normal = better ? other : joined_normal;
      joined.coverage = better ? shown[i] : joined.coverage;
    }
    for (bool joins = nearest < SURFACES; joins; joins = false) {
      uvec3 facet = joined.facet;
      float depth = joined.depth;
      joined = dcaa_merged(joined, joined_normal, part, normal);
      joined.facet = facet;
      joined.depth = depth;
      for (uint i = 0u; i < SURFACES; ++i) {
        surface[i] = dcaa_select(nearest == i, joined, surface[i]);
        shown[i] = nearest == i ? joined.coverage : which == i ? uvec2(0u) : shown[i];
      }
    }
  }
}

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uint count = field_of(read_count_word(pixel), 0u, DCAA_COUNT_BITS);
  vec3 sum = vec3(0.0);
  uint covered = 0u, executions = 0u;
  // Loops, here and below, so that groups of pixels skip what none of them needs.
  for (bool any_surface = count > 0u; any_surface; any_surface = false) {
    DcaaSurface surface[DCAA_MAX_SURFACES];
    read_surfaces(pixel, surface);
    vec3 ray = dcaa_ray(pixel, view);
    vec2 slopes[DCAA_MAX_SURFACES];
    uvec2 shown[DCAA_MAX_SURFACES];
    for (uint s = 0u; s < SURFACES; ++s) {
      slopes[s] = dcaa_slopes(dcaa_facet(surface[s].facet), surface[s].depth, ray, view);
      shown[s] = surface[s].coverage;
    }
    // What of each is in front. Of two planes, one is in front on one side of a line; most don't meet within the pixel.
    uint unresolved = count > 1u ? (1u << count) - 1u : 0u;
    while (unresolved != 0u) {
      uint which = uint(findLSB(unresolved));
      unresolved &= unresolved - 1u;
      vec3 plane = vec3(surface[0].depth, slopes[0]);
      uvec2 own = surface[0].coverage, hidden = uvec2(0u);
      for (uint i = 1u; i < SURFACES; ++i) {
        plane = which == i ? vec3(surface[i].depth, slopes[i]) : plane;
        own = which == i ? surface[i].coverage : own;
      }
      uint rivals = 0u;
      for (uint i = 0u; i < SURFACES; ++i) {
        float ahead = surface[i].depth - plane.x;
        float reach = plane_reach(slopes[i] - plane.yz);
        bool over = i < count && i != which && (surface[i].coverage & own) != uvec2(0u);
        hidden |= over && ahead > reach ? surface[i].coverage : uvec2(0u);
        rivals |= over && abs(ahead) <= reach ? 1u << i : 0u;
      }
      while (rivals != 0u) {
        uint rival = uint(findLSB(rivals));
        rivals &= rivals - 1u;
        vec3 other = vec3(surface[0].depth, slopes[0]);
        uvec2 covered_by = surface[0].coverage;
        for (uint i = 1u; i < SURFACES; ++i) {
          other = rival == i ? vec3(surface[i].depth, slopes[i]) : other;
          covered_by = rival == i ? surface[i].coverage : covered_by;
        }
        hidden |= covered_by & samples_ahead(other - plane, rival < which);
      }
      for (uint i = 0u; i < SURFACES; ++i) shown[i] = which == i ? own & ~hidden : shown[i];
    }

    if (LEAST_SHOWN > 0u) fold(surface, shown, ray);
    uint left = 0u;  // surfaces yet to shade
    for (uint s = 0u; s < SURFACES; ++s) left |= shown[s] != uvec2(0u) ? 1u << s : 0u;
    while (left != 0u) {
      uint which = uint(findLSB(left));
      left &= left - 1u;
      DcaaSurface s = surface[0];
      vec2 slope = slopes[0];
      uvec2 samples = shown[0];
      for (uint i = 1u; i < SURFACES; ++i) {
        bool here = which == i;
        s.albedo = here ? surface[i].albedo : s.albedo;
        s.normal = here ? surface[i].normal : s.normal;
        s.roughness = here ? surface[i].roughness : s.roughness;
        s.emission = here ? surface[i].emission : s.emission;
        s.moments = here ? surface[i].moments : s.moments;
        s.depth = here ? surface[i].depth : s.depth;
        slope = here ? slopes[i] : slope;
        samples = here ? shown[i] : samples;
      }
      uint here = dcaa_count(samples);
      vec3 value = resolvable(radiance_of(s, slope, samples));
      TELL_EXECUTION(pixel, which, here, samples,
                     place_at(samples != kWholePixel ? mask_centroid(samples) : vec2(0.0), s.depth, slope), value);
      sum += float(int(here)) * value;
      covered += here;
      ++executions;
    }
  }
  vec3 mean = (sum + resolvable(frame.sky.rgb) * float(int(SAMPLES - covered))) * (1.0 / float(SAMPLES));
  vec3 radiance = resolved_radiance(mean);
  out_radiance = vec4(radiance, float(executions));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
