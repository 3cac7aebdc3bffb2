// Between the front-end's depth planes (reversed depth, linear on the screen) and the depths that surfaces keep: the distance
// along the view with its slopes at the shading point, which half precision holds at any distance; or, with
// STREAM_CLIP_SPACE and under parallel projections, the reversed depth with its sign turned.
// Reads: frame constants. Needs compress.glsl before it.
#ifndef SUBPIXEL_STREAMING_PLANE_GLSL
#define SUBPIXEL_STREAMING_PLANE_GLSL

// 1 / distance is linear in window position and depth: the last row of the clip-to-world matrix, by (x, y, z, 1).
vec4 inverse_distance_row() {
  mat4 m = frame.inverse_view_projection;
  return vec4(m[0][3], m[1][3], m[2][3], m[3][3]);
}
bool keeps_distance(vec4 row) { return !stream_option(STREAM_CLIP_SPACE) && row.z != 0.0; }

// Depth at the pixel's centre and slopes of the plane that touches the triangle at `offset` from the centre, in pixels.
// Slopes are rounded first, so that the plane goes through that point whatever the rounding did.
void stream_plane(DepthPlane plane, ivec2 pixel, vec2 offset, out float depth, out uint slopes) {
  vec4 row = inverse_distance_row();
  precise float z = clamp(plane.centre + plane.dx * offset.x + plane.dy * offset.y, plane.smallest, plane.largest);
  vec2 ndc_per_pixel = 2.0 * frame.viewport.zw;
  vec2 ndc = (vec2(frame_pixel(pixel)) + 0.5 + offset) * ndc_per_pixel - 1.0;
  precise float inverse = max(dot(row.xy, ndc) + (row.z * z + row.w), 1e-12);
  precise float distance = 1.0 / inverse;
  precise vec2 slope = (row.z * vec2(plane.dx, plane.dy) + row.xy * ndc_per_pixel) * (-distance * distance);
  bool by_distance = keeps_distance(row);
  slope = by_distance ? slope : -vec2(plane.dx, plane.dy);
  slopes = stream_pack_slopes(slope);
  precise vec2 rounded = unpackHalf2x16(slopes) * offset;
  depth = (by_distance ? distance : -z) - (rounded.x + rounded.y);
}

// Reversed depth at the centre of `pixel` of a stored depth.
float stream_reversed_depth(float depth, ivec2 pixel) {
  vec4 row = inverse_distance_row();
  vec2 ndc = (vec2(frame_pixel(pixel)) + 0.5) * 2.0 * frame.viewport.zw - 1.0;
  float inverse = 1.0 / max(depth, 1e-12);
  return keeps_distance(row) ? (inverse - dot(row.xy, ndc) - row.w) / row.z : -depth;
}

#endif
