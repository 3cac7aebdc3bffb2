// Walks the pixels that the pattern's reach of a small triangle touches: one invocation for each triangle. The device's
// rasteriser hands 4x4 blocks to fragment shaders, of which a triangle of a few pixels fills little; here all lanes have a pixel
// of a triangle of their own.
// Needs coverage.glsl, and visit(pixel, edges) before it, which each pixel goes to; some that the triangle misses, too.
#ifndef SUBPIXEL_SMALL_WALK_GLSL
#define SUBPIXEL_SMALL_WALK_GLSL

// Which triangle an invocation takes. A device gives each thread a run of groups. Triangles, in `groups` groups of 64, are dealt
// out to `runs` runs, so that all have their share of large ones, which stand together; and each run stays in order, so that
// what stands together on the screen is drawn together, and lists by pixel are nearly sorted.
uint dealt_item(uint groups, uint runs) {
  uint columns = (groups + runs - 1u) / runs;
  return (gl_WorkGroupID.x % columns * runs + gl_WorkGroupID.x / columns) * 64u + gl_LocalInvocationID.x;
}

// Narrows [first, last] to the pixels of a row that one edge's half plane, widened by a pixel's samples, reaches. `edge`: the
// edge function at the centre of pixel `origin`; `step`: what a pixel to the right adds. Floats are exact enough: rows are
// short, and a pixel too many is only tested.
void narrow_row(int edge, int step, int origin, inout int first, inout int last) {
  float crossing = float(-edge) / float(step);
  if (step > 0) first = max(first, origin + int(ceil(crossing - 0.01)));
  if (step < 0) last = min(last, origin + int(floor(crossing + 0.01)));
  if (step == 0 && edge < 0) last = first - 1;
}

// `v0`, `v1`, `v2` as in TriangleRecord; `size`: of the viewport, pixels.
void walk_small_triangle(ivec2 v0, ivec2 v1, ivec2 v2, uvec2 size) {
  // As set-up's bounds: a sample is less than half a pixel (and 1/128) from its pixel's centre.
  ivec2 low = min(min(v0, v1), v2), high = max(max(v0, v1), v2);
  ivec2 first = max((low - 1) >> 8, ivec2(0)), last = min((high + 1) >> 8, ivec2(size) - 1);
  ivec2 origin = first * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2;
  ivec2 along[3] = ivec2[3](v1 - v0, v2 - v1, v0 - v2), from[3] = ivec2[3](v0, v1, v2);

  // Edge functions at the centre of the row's pixel first.x; all within 32 bits for small triangles (coverage.glsl).
  int row[3], step_x[3], step_y[3], reach[3];
  PixelEdges edges;
  for (uint k = 0u; k < 3u; ++k) {
    ivec2 away = origin - from[k];
    row[k] = along[k].x * away.y - along[k].y * away.x - (edge_inclusive(along[k]) ? 0 : 1);
    step_x[k] = -along[k].y * SUBPIXEL_SNAP;
    step_y[k] = along[k].x * SUBPIXEL_SNAP;
    reach[k] = (abs(along[k].x) + abs(along[k].y)) * (SUBPIXEL_SNAP / 2);
    edges.a[k] = -float(along[k].y);
    edges.b[k] = float(along[k].x);
    row[k] -= step_y[k];
  }
  ivec2 pixel = ivec2(first.x, first.y - 1);
  int row_end = first.x - 1;
  // Every turn is a pixel; the rows' ends are found on the way, so that lanes do not wait for each other's rows.
  while (true) {
    if (pixel.x > row_end) {
      ++pixel.y;
      if (pixel.y > last.y) break;
      pixel.x = first.x;
      row_end = last.x;
      for (uint k = 0u; k < 3u; ++k) {
        row[k] += step_y[k];
        narrow_row(row[k] + reach[k], step_x[k], first.x, pixel.x, row_end);
      }
    }
    if (pixel.x <= row_end) {
      for (uint k = 0u; k < 3u; ++k)
        edges.base[k] = float(clamp((row[k] + (pixel.x - first.x) * step_x[k]) >> 1, -8388608, 8388608));
      visit(pixel, edges);
      ++pixel.x;
    }
  }
}

#endif
