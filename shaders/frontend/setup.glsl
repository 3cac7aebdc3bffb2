// Triangle set-up shared by the pass that sets up whole triangles and the one that sets up clipped pieces.
// Reads: frame constants; SAMPLES. Writes: nothing; returns a TriangleRecord.
#ifndef SUBPIXEL_SETUP_GLSL
#define SUBPIXEL_SETUP_GLSL

#include "include/frame.glsl"
#include "include/coverage.glsl"
#include "frontend/small_triangles.glsl"

layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;

// How far a sample of the pattern can lie from the pixel's centre, pixels, with 1/64 pixel for the rasteriser's own snapping and
// the rounding of the hull's corners.
float sample_reach() {
  if (SAMPLES == 1u) return 0.015625;
  return SAMPLES <= 8u ? 0.453125 : 0.515625;
}

// What a hull's second triangle costs a geometry pass, in pixels of hull.
const float kSecondTriangle_px = 6.0;
// Corners farther out would lose the fraction that the reach allows for rounding.
const float kFarthestCorner_px = 16384.0;

bool near_enough(vec2 a, vec2 b, vec2 c, vec2 d) {
  vec2 farthest = max(max(abs(a), abs(b)), max(abs(c), abs(d)));
  return max(farthest.x, farthest.y) < kFarthestCorner_px;
}

// Corners of a triangle or quadrilateral that contains the centre of every pixel that has a sample in v0 v1 v2; returns how many
// triangles it is drawn as: 0 1 2, and 0 2 3. Four candidates contain them: the triangle with its edges pushed outwards by the
// reach; that with its sharpest tip cut off; a right triangle over the dilated bounding box; the box. The smallest is used.
// Corners are never clamped, which would cut slivers.
// `w`: twice the triangle's area in pixels, exact. The box may be cut to the viewport: what it loses holds no pixel.
uint conservative_hull(vec2 p[3], double w, out vec2 hull[4]) {
  float reach = sample_reach();
  vec2 low = max(min(min(p[0], p[1]), p[2]) - reach, vec2(-1.0));
  vec2 high = min(max(max(p[0], p[1]), p[2]) + reach, frame.viewport.xy + 1.0);
  vec2 size = high - low;
  // A right triangle with legs twice the box's sides and its right angle on a corner of the box covers the box.
  hull = vec2[4](low, vec2(low.x + 2.0 * size.x, low.y), vec2(low.x, low.y + 2.0 * size.y), low);
  uint triangles = 1u;
  float best = 2.0 * size.x * size.y;
  if (0.5 * best + kSecondTriangle_px < best) {
    hull = vec2[4](low, vec2(high.x, low.y), high, vec2(low.x, high.y));
    triangles = 2u;
    best = 0.5 * best + kSecondTriangle_px;
  }
  if (w <= 0.0LF) return triangles;

  // Lines n.x = c with n the outward normal; pushing a line by the reach in both axes adds reach * (|nx| + |ny|). In doubles:
  // the corners of slivers are quotients of small differences.
  dvec2 n[3];
  double c[3];
  for (uint k = 0u; k < 3u; ++k) {
    dvec2 along = dvec2(p[(k + 1u) % 3u]) - dvec2(p[k]);
    n[k] = dvec2(along.y, -along.x);
    c[k] = double(reach) * (abs(n[k].x) + abs(n[k].y));
  }
  // Corner k between lines k - 1 and k, relative to vertex k: solve n_a.x = c_a, n_b.x = c_b. The determinants are all w.
  dvec2 q[3];
  vec2 out_by[3];
  for (uint k = 0u; k < 3u; ++k) {
    uint a = (k + 2u) % 3u;
    dvec2 away = dvec2(c[a] * n[k].y - c[k] * n[a].y, c[k] * n[a].x - c[a] * n[k].x) / w;
    q[k] = dvec2(p[k]) + away;
    out_by[k] = vec2(away);
  }
  vec2 e1 = vec2(q[1] - q[0]), e2 = vec2(q[2] - q[0]);
  float area = 0.5 * abs(e1.x * e2.y - e2.x * e1.y);
  if (area < best && near_enough(vec2(q[0]), vec2(q[1]), vec2(q[2]), vec2(0.0))) {
    hull = vec2[4](vec2(q[0]), vec2(q[1]), vec2(q[2]), vec2(q[0]));
    triangles = 1u;
    best = area;
  }

  // The tip farthest from its vertex, cut at right angles to the way there, behind everything that belongs to the triangle.
  vec3 lengths = vec3(dot(out_by[0], out_by[0]), dot(out_by[1], out_by[1]), dot(out_by[2], out_by[2]));
  uint tip = lengths.x >= lengths.y && lengths.x >= lengths.z ? 0u : lengths.y >= lengths.z ? 1u : 2u;
  uint left = (tip + 1u) % 3u, right = (tip + 2u) % 3u;
  float tip_length = sqrt(lengths[tip]);
  vec2 direction = out_by[tip] / max(tip_length, 1e-20);
  float reached = max(max(dot(direction, p[left] - p[tip]), dot(direction, p[right] - p[tip])), 0.0) +
                  reach * (abs(direction.x) + abs(direction.y));
  float cut = tip_length - reached;
  vec2 to_left = vec2(q[left] - q[tip]), to_right = vec2(q[right] - q[tip]);
  float height_left = -dot(direction, to_left), height_right = -dot(direction, to_right);
  float quad_area = area * (1.0 - cut * cut / (height_left * height_right)) + kSecondTriangle_px;
  if (cut > 0.0 && cut < height_left && cut < height_right && quad_area < best) {
    vec2 cut_left = vec2(q[tip] + (q[left] - q[tip]) * double(cut / height_left));
    vec2 cut_right = vec2(q[tip] + (q[right] - q[tip]) * double(cut / height_right));
    if (near_enough(vec2(q[left]), vec2(q[right]), cut_left, cut_right)) {
      hull = vec2[4](vec2(q[left]), vec2(q[right]), cut_right, cut_left);
      triangles = 2u;
    }
  }
  return triangles;
}

// Sets up one triangle that is inside the guard band and in front of the eye. Returns the triangles of its hull, 0 when it is empty after snapping,
// faces away and `cull_back`, or covers no sample of any pixel of the viewport.
uint set_up_triangle(vec4 c0, vec4 c1, vec4 c2, bool cull_back, bool mirrored, out TriangleRecord record) {
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

  ivec2 low = min(min(v0, v1), v2), high = max(max(v0, v1), v2), first, last;
  cells_in_reach(v0, v1, v2, ivec2(frame.viewport.xy), kPixelCell, first, last);
  alive = alive && all(lessThanEqual(first, last));

  bool large = max(high.x - low.x, high.y - low.y) > SUBPIXEL_SMALL_PX * SUBPIXEL_SNAP;

  // Small triangles: does any sample lie inside? A loop, so that large ones don't pay. Of many samples one nearly always does
  // where a triangle reaches more than one pixel.
  ivec2 extent = last - first + 1;
  int pixels = extent.x * extent.y;
  int most = SAMPLES > 16u ? 1 : 6;
  int tested = (alive && !large && pixels <= most) ? pixels : 0;
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
  vec2 hull[4];
  uint triangles = conservative_hull(p, area * (1.0LF / 65536.0LF), hull);
  record.hull01 = floatBitsToUint(vec4(hull[0], hull[1]));
  record.hull2_id = uvec4(floatBitsToUint(hull[2]), 0u, 0u);
  // What passes compare with pixels is the band's; the hull, which is drawn over all of the frame, is not.
  ivec2 corner = frame_pixel(ivec2(0));
  record.v01 = uvec4(ivec4(v0, v1) - corner.xyxy * SUBPIXEL_SNAP);
  reference -= corner;
  record.v2_ref = uvec4(uvec2(v2 - corner * SUBPIXEL_SNAP), uint(reference.x) | uint(reference.y) << 16, (back ? RECORD_BACK_FACE : 0u) | (large ? RECORD_LARGE : 0u));
  // Slopes beyond float's range belong to triangles seen edge-on, whose depths the clamp decides.
  record.depth = floatBitsToUint(vec4(clamp(vec3(z, dx * 256.0LF, dy * 256.0LF), -1e30, 1e30), min(min(n0.z, n1.z), n2.z)));
  record.depth2 = uvec4(floatBitsToUint(max(max(n0.z, n1.z), n2.z)), floatBitsToUint(hull[3]), 0u);
  return alive ? triangles : 0u;
}

// Can the hull hold the centre of a pixel of the band? A row to spare for the rasteriser's rounding.
bool in_band(TriangleRecord record) {
  vec4 rows = uintBitsToFloat(uvec4(record.hull01.yw, record.hull2_id.y, record.depth2.z));
  // The fourth corner is the first again where the hull is a triangle.
  float low = min(min(rows.x, rows.y), min(rows.z, rows.w)), high = max(max(rows.x, rows.y), max(rows.z, rows.w));
  float first = float(frame.band.x);
  return high > first - 1.0 && low < first + float(frame.band.y) + 1.0;
}

// About how many pixels have their centre within the pattern's reach of a whole triangle.
float pixels_reached(TriangleRecord record) {
  vec2 v0 = vec2(ivec2(record.v01.xy)) / 256.0, v1 = vec2(ivec2(record.v01.zw)) / 256.0;
  vec2 v2 = vec2(ivec2(record.v2_ref.xy)) / 256.0;
  vec2 size = max(max(v0, v1), v2) - min(min(v0, v1), v2);
  float area = 0.5 * abs((v1.x - v0.x) * (v2.y - v0.y) - (v2.x - v0.x) * (v1.y - v0.y));
  float across = 2.0 * sample_reach();
  return area + across * (size.x + size.y) + across * across;
}

// Blocks of the bounding box of a small triangle.
uint blocks_reached(TriangleRecord record) {
  ivec2 first, last;
  cells_in_reach(ivec2(record.v01.xy), ivec2(record.v01.zw), ivec2(record.v2_ref.xy), band_size(), kBlockCell, first, last);
  ivec2 extent = max(last - first + 1, ivec2(0));  // none where only the hull reaches the band
  return uint(extent.x * extent.y);
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
