#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: IMAGE=-DIMAGE BUFFER=
// Final depth resolve (Wang et al. 2015, section 3.4): the nearest plane at each sample, one lighting execution for each
// surface that any sample shows, weights n_i / N; samples that nothing covers show the sky.
// Reads: the pixel's state, the camera (storage slot 2), shadow map. Writes: linear radiance with the lighting executions in
// a; display values.
layout(constant_id = 0) const uint SAMPLES = 64u;
#include "include/lights.glsl"
#include "include/resolve.glsl"
#include "techniques/dcaa/surface.glsl"
#include "techniques/dcaa/coverage.glsl"
#include "techniques/dcaa/state.glsl"
#include "techniques/dcaa/state_read.glsl"

layout(set = 0, binding = 3, scalar) readonly buffer ViewBlock { DcaaView view; };
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_display;

void main() {
  ivec2 pixel = pixel_of(gl_FragCoord.xy);
  uint count = read_count_word(pixel) & ((1u << DCAA_COUNT_BITS) - 1u);
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
      shown[s] = s == 0u ? surface[0].coverage : uvec2(0u);
    }
    for (bool several = count > 1u; several; several = false) {
      for (uint s = 0u; s < SURFACES; ++s) shown[s] = uvec2(0u);
      for (uint i = 0u; i < SAMPLES; ++i) {
        vec2 offset = vec2(sample_offset(SAMPLES, i)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
        uint bit = 1u << (i & 31u);
        float nearest = -1e30;
        uint owner = SURFACES;
        for (uint s = 0u; s < SURFACES; ++s) {
          float depth = surface[s].depth + slopes[s].x * offset.x + slopes[s].y * offset.y;
          bool nearer = s < count && (surface[s].coverage[i >> 5] & bit) != 0u && depth > nearest;
          nearest = nearer ? depth : nearest;
          owner = nearer ? s : owner;
        }
        for (uint s = 0u; s < SURFACES; ++s) shown[s][i >> 5] |= owner == s ? bit : 0u;
      }
    }

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
        s.depth = here ? surface[i].depth : s.depth;
        slope = here ? slopes[i] : slope;
        samples = here ? shown[i] : samples;
      }
      vec2 offset = vec2(0.0);
      for (bool part = samples != kWholePixel; part; part = false) offset = mask_centroid(samples);
      Surface lit = unpack_surface(uvec4(s.albedo, s.normal, s.roughness | 255u << 8, s.emission));
      float depth = clamp(s.depth + dot(slope, offset), 0.0, 1.0);
      lit.position = world_position(gl_FragCoord.xy + offset, depth);
      uint here = dcaa_count(samples);
      sum += float(int(here)) * resolvable(shade(lit, normalize(frame.eye.xyz - lit.position)));
      covered += here;
      ++executions;
    }
  }
  vec3 mean = (sum + resolvable(frame.sky.rgb) * float(int(SAMPLES - covered))) * (1.0 / float(SAMPLES));
  vec3 radiance = resolved_radiance(mean);
  out_radiance = vec4(radiance, float(executions));
  out_display = vec4(display_from_radiance(radiance), 1.0);
}
