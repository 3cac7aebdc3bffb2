// Triangle set-up shared by the pass that sets up whole triangles and the one that sets up clipped pieces.
// Reads: frame constants; specialization constant 0, samples per pixel. Writes: nothing; returns a TriangleRecord.
#ifndef SUBPIXEL_SETUP_GLSL
#define SUBPIXEL_SETUP_GLSL

#include "include/frame.glsl"
#include "include/coverage.glsl"

layout(constant_id = 0) const uint SAMPLES = 8u;

// How far a sample of the pattern can lie from the pixel's centre, pixels, with 1/16 pixel for the rasteriser's own snapping.
float sample_reach() {
  if (SAMPLES == 1u) return 0.0625;
  return SAMPLES <= 8u ? 0.5 : 0.5625;
}

// Corners of a triangle that contains the centre of every pixel that has a sample in v0 v1 v2. Two candidates contain them:
// the triangle with its edges pushed outwards by the reach, and a right triangle over the dilated bounding box. The smaller
// one is used; corners are never clamped, which would cut slivers.
// `w`: twice the triangle's area in pixels, computed exactly and rounded once. The box may be cut to the viewport: what
// it loses holds no pixel.
void conservative_hull(vec2 p[3], float w, out vec2 hull[3]) {
  float reach = sample_reach();
  vec2 low = max(min(min(p[0], p[1]), p[2]) - reach, vec2(-1.0));
  vec2 high = min(max(max(p[0], p[1]), p[2]) + reach, frame.viewport.xy + 1.0);
  vec2 size = high - low;
  // A right triangle with legs twice the box's sides and its right angle on a corner of the box covers the box.
  hull[0] = low;
  hull[1] = vec2(low.x + 2.0 * size.x, low.y);
  hull[2] = vec2(low.x, low.y + 2.0 * size.y);
  float best = 2.0 * size.x * size.y;

  vec2 d0 = p[1] - p[0], d1 = p[2] - p[1], d2 = p[0] - p[2];
  // Lines n.x = c with n the outward normal; pushing a line by the reach in both axes adds reach * (|nx| + |ny|).
  vec2 n0 = vec2(d0.y, -d0.x), n1 = vec2(d1.y, -d1.x), n2 = vec2(d2.y, -d2.x);
  float c0 = reach * (abs(n0.x) + abs(n0.y)), c1 = reach * (abs(n1.x) + abs(n1.y)), c2 = reach * (abs(n2.x) + abs(n2.y));
  // Corner between lines a and b, relative to their shared vertex: solve n_a.x = c_a, n_b.x = c_b.
  // The three determinants are all w.
  if (w > 0.0) {
    vec2 q1 = p[1] + vec2(c0 * n1.y - c1 * n0.y, c1 * n0.x - c0 * n1.x) / w;
    vec2 q2 = p[2] + vec2(c1 * n2.y - c2 * n1.y, c2 * n1.x - c1 * n2.x) / w;
    vec2 q0 = p[0] + vec2(c2 * n0.y - c0 * n2.y, c0 * n2.x - c2 * n0.x) / w;
    float area = 0.5 * abs((q1.x - q0.x) * (q2.y - q0.y) - (q2.x - q0.x) * (q1.y - q0.y));
    if (area < best) {
      hull[0] = q0;
      hull[1] = q1;
      hull[2] = q2;
    }
  }
}

// Sets up one triangle that is inside the guard band and in front of the eye. Returns false when it is empty after snapping,
// faces away and `cull_back`, or covers no sample of any pixel of the viewport.
bool set_up_triangle(vec4 c0, vec4 c1, vec4 c2, bool cull_back, bool mirrored, out TriangleRecord record) {
  vec3 n0 = c0.xyz / c0.w, n1 = c1.xyz / c1.w, n2 = c2.xyz / c2.w;
  vec2 half_size = frame.viewport.xy * 0.5;
  ivec2 v0 = ivec2(floor((n0.xy * half_size + half_size) * float(SUBPIXEL_SNAP) + 0.5));
  ivec2 v1 = ivec2(floor((n1.xy * half_size + half_size) * float(SUBPIXEL_SNAP) + 0.5));
  ivec2 v2 = ivec2(floor((n2.xy * half_size + half_size) * float(SUBPIXEL_SNAP) + 0.5));
  double area = double(v1.x - v0.x) * double(v2.y - v0.y) - double(v2.x - v0.x) * double(v1.y - v0.y);

  // Counter-clockwise seen from outside (the front, glTF) runs against positive area on a screen whose y points down.
  bool back = (area > 0.0LF) != mirrored;
  bool alive = area != 0.0LF && !(cull_back && back);
  if (area < 0.0LF) {
    ivec2 v = v1;
    v1 = v2;
    v2 = v;
    vec3 n = n1;
    n1 = n2;
    n2 = n;
    area = -area;
  }

  // Pixels that can hold a covered sample: a sample is less than half a pixel (and 1/128) from its pixel's centre.
  ivec2 low = min(min(v0, v1), v2), high = max(max(v0, v1), v2);
  ivec2 first = max((low - 1) >> 8, ivec2(0)), last = min((high + 1) >> 8, ivec2(frame.viewport.xy) - 1);
  alive = alive && all(lessThanEqual(first, last));

  int size = max(high.x - low.x, high.y - low.y);
  bool huge = size > SUBPIXEL_LARGE_PX * SUBPIXEL_SNAP, large = size > SUBPIXEL_SMALL_PX * SUBPIXEL_SNAP && !huge;

  // Small triangles: does any sample lie inside? A loop, so that large ones don't pay.
  ivec2 extent = last - first + 1;
  int pixels = extent.x * extent.y;
  int tested = (alive && !large && !huge && pixels <= 6) ? pixels : 0;
  bool touched = tested == 0;
  ivec2 pixel = first;
  for (int k = 0; k < tested; ++k) {
    PixelEdges edges = pixel_edges(v0, v1, v2, pixel, 0u);
    for (uint i = 0u; i < SAMPLES && !touched; ++i) touched = small_covers(edges, sample_offset(SAMPLES, i));
    if (touched) break;
    ++pixel.x;
    if (pixel.x > last.x) pixel = ivec2(first.x, pixel.y + 1);
  }
  alive = alive && touched;

  // One depth plane, through the snapped vertices, anchored at a pixel near the triangle's middle.
  ivec2 reference = clamp((low + high) >> 9, ivec2(0), ivec2(frame.viewport.xy) - 1);
  double z0 = double(n0.z), z1 = double(n1.z) - z0, z2 = double(n2.z) - z0;
  double inverse_area = area > 0.0LF ? 1.0LF / area : 0.0LF;
  double dx = (z1 * double(v2.y - v0.y) - z2 * double(v1.y - v0.y)) * inverse_area;
  double dy = (z2 * double(v1.x - v0.x) - z1 * double(v2.x - v0.x)) * inverse_area;
  ivec2 from_v0 = reference * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2 - v0;
  double z = z0 + dx * double(from_v0.x) + dy * double(from_v0.y);

  vec2 p[3] = vec2[3](vec2(v0) / 256.0, vec2(v1) / 256.0, vec2(v2) / 256.0);
  vec2 hull[3];
  conservative_hull(p, float(area * (1.0LF / 65536.0LF)), hull);
  record.hull01 = floatBitsToUint(vec4(hull[0], hull[1]));
  record.hull2_id = uvec4(floatBitsToUint(hull[2]), 0u, 0u);
  record.v01 = uvec4(ivec4(v0, v1));
  record.v2_ref = uvec4(uvec2(v2), uint(reference.x) | uint(reference.y) << 16, (back ? RECORD_BACK_FACE : 0u) | (large ? RECORD_LARGE : 0u) | (huge ? RECORD_HUGE : 0u));
  // Slopes beyond float's range belong to triangles seen edge-on, whose depths the clamp decides.
  record.depth = floatBitsToUint(vec4(clamp(vec3(z, dx * 256.0LF, dy * 256.0LF), -1e30, 1e30), min(min(n0.z, n1.z), n2.z)));
  record.depth2 = uvec4(floatBitsToUint(max(max(n0.z, n1.z), n2.z)), 0u, 0u, 0u);
  return alive;
}

// Signed distances to the six clip planes: near (reversed depth: z <= w), far (z >= 0), and the guard band.
// Inside when not negative.
float plane_distance(uint plane, vec4 c) {
  vec2 guard = 1.0 + float(SUBPIXEL_GUARD_BAND_PX) * 2.0 * frame.viewport.zw;
  switch (plane) {
    case 0u: return c.w - c.z;
    case 1u: return c.z;
    case 2u: return guard.x * c.w + c.x;
    case 3u: return guard.x * c.w - c.x;
    case 4u: return guard.y * c.w + c.y;
    default: return guard.y * c.w - c.y;
  }
}

#endif
