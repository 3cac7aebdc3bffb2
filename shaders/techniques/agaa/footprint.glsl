// Mean and covariance of the positions of an aggregate's samples, from their depths (AGAA paper, section 3.5.3).
// Reads: visibility (slot 0), frame constants. Needs shading.glsl and SAMPLES.
#ifndef SUBPIXEL_AGAA_FOOTPRINT_GLSL
#define SUBPIXEL_AGAA_FOOTPRINT_GLSL

#include "techniques/agaa/sample_position.glsl"

// `view`: the unit vector from the mean to the eye.
Footprint aggregate_footprint(mat4 view_from_clip, ivec2 pixel, uint mask, out vec3 view) {
  // Relative to one of the positions, so that squares lose no digits to the distance.
  uint first = uint(findLSB(mask));
  vec2 offset = vec2(sample_offset(SAMPLES, first)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
  vec3 origin = view_position(view_from_clip, frame.viewport, frame_pixel(pixel), offset,
                              uintBitsToFloat(visible_depths(pixel, SAMPLES, first / 4u)[first & 3u]));
  vec3 mean = vec3(0.0), squares = vec3(0.0), mixed = vec3(0.0);
  for (uint quad = 0u; quad < SAMPLES / 4u; ++quad) {
    vec4 depths = uintBitsToFloat(visible_depths(pixel, SAMPLES, quad));
    for (uint i = 0u; i < 4u; ++i) {
      uint s = 4u * quad + i;
      offset = vec2(sample_offset(SAMPLES, s)) * (1.0 / float(SUBPIXEL_SAMPLE_GRID));
      vec3 p = view_position(view_from_clip, frame.viewport, frame_pixel(pixel), offset, depths[i]) - origin;
      p = (mask & (1u << s)) != 0u ? p : vec3(0.0);
      mean += p;
      squares += p * p;
      mixed += p.xxy * p.yzz;
    }
  }
  float each = 1.0 / float(int(bitCount(mask)));
  mean *= each;
  vec3 variance = max(squares * each - mean * mean, 0.0);
  vec3 covariance = mixed * each - mean.xxy * mean.yzz;
  // Cholesky's root, lower triangular; rows that rounding leaves without variance are 0.
  float a = sqrt(variance.x);
  float inverse_a = a > 0.0 ? 1.0 / a : 0.0;
  float b = covariance.x * inverse_a, d = covariance.y * inverse_a;
  float c = sqrt(max(variance.y - b * b, 0.0));
  float e = c > 1e-3 * sqrt(variance.y) ? (covariance.z - b * d) / c : 0.0;
  float f = sqrt(max(variance.z - d * d - e * e, 0.0));
  mat3 world_from_view = transpose(mat3(frame.view));
  vec3 from_eye = world_from_view * (origin + mean);
  Footprint footprint;
  footprint.mean = frame.eye.xyz + from_eye;
  footprint.axis = vec3[3](world_from_view * vec3(a, b, d), world_from_view * vec3(0.0, c, e),
                           world_from_view * vec3(0.0, 0.0, f));
  view = from_eye * -inversesqrt(max(dot(from_eye, from_eye), 1e-30));
  return footprint;
}

#endif
