// What a fragment brings to its pixel's surfaces.
// Reads: what fragment.glsl reads. Needs fragment.glsl with attributes and compress.glsl before it.
#ifndef SUBPIXEL_STREAMING_FRAGMENT_GLSL
#define SUBPIXEL_STREAMING_FRAGMENT_GLSL

#include "techniques/streaming/plane.glsl"

// shading_offset() of the geometry that `mask` came from.
vec2 mask_offset(PixelEdges edges, uint mask) {
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < SAMPLES; ++i) sum += (mask & (1u << i)) != 0u ? vec2(sample_offset(SAMPLES, i)) : vec2(0.0);
  float count = float(int(bitCount(mask)));
  return covers(edges, ivec2(0)) ? vec2(0.0) : sum / (max(count, 1.0) * float(SUBPIXEL_SAMPLE_GRID));
}

// All but the masks. `geometry`: the samples that the triangle covers, before alpha.
StreamSurface stream_fragment(ivec2 pixel, PixelEdges edges, DepthPlane plane, uint geometry) {
  vec2 offset = mask_offset(edges, geometry);
  uvec4 packed = pack_surface(fragment_surface(pixel, offset));
  StreamSurface fragment;
  stream_plane(plane, pixel, offset, fragment.depth, fragment.slopes);
  fragment.coverage = fragment.resolved = 0u;
  fragment.albedo = packed.x;
  fragment.normal = packed.y;
  fragment.roughness = packed.z & 255u;
  fragment.emission = packed.w;
  return fragment;
}

#endif
