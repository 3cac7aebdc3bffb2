// Walks the cells (pixels, or what WALK_CELL says) that the pattern's reach of a small triangle touches: one invocation for each
// triangle. The device's rasteriser hands 4x4 blocks to fragment shaders, of which a triangle of a few pixels fills little; here all
// lanes have a cell of a triangle of their own.
// Needs coverage.glsl, and visit(cell, edges) before it, which each cell goes to; some that the triangle misses, too. The edges
// are those at the centre of a pixel, of no use for other cells.
#ifndef SUBPIXEL_SMALL_WALK_GLSL
#define SUBPIXEL_SMALL_WALK_GLSL

#include "frontend/small_triangles.glsl"

#ifndef WALK_CELL
#define WALK_CELL kPixelCell
#endif

// Which triangle an invocation takes. A device gives each thread a run of groups. Triangles, in groups of 64, are dealt out to
// rows of groups, so that all have their share of large ones, which stand together; and each row stays in order, so that
// what stands together on the screen is drawn together, and lists by pixel are nearly sorted.
uint dealt_item() {
  return (gl_WorkGroupID.x * gl_NumWorkGroups.y + gl_WorkGroupID.y) * 64u + gl_LocalInvocationID.x;
}

// Narrows [first, last] to the cells of a row that one edge's half plane, widened by a cell's samples, reaches. `edge`: the
// edge function at the centre of cell `origin`; `step`: what a cell to the right adds. Floats are exact enough: rows are
// short, and a cell too many is only tested.
void narrow_row(int edge, int step, int origin, inout int first, inout int last) {
  float crossing = float(-edge) / float(step);
  if (step > 0) first = max(first, origin + int(ceil(crossing - 0.01)));
  if (step < 0) last = min(last, origin + int(floor(crossing + 0.01)));
  if (step == 0 && edge < 0) last = first - 1;
}

// `v0`, `v1`, `v2` as in TriangleRecord; `size`: of the viewport, pixels.
void walk_small_triangle(ivec2 v0, ivec2 v1, ivec2 v2, uvec2 size) {
  ivec2 first, last;
  cells_in_reach(v0, v1, v2, ivec2(size), WALK_CELL, first, last);
  ivec2 cell_size = ivec2(1) << WALK_CELL;
  ivec2 origin = (first * SUBPIXEL_SNAP + SUBPIXEL_SNAP / 2) * cell_size;
  ivec2 along[3] = ivec2[3](v1 - v0, v2 - v1, v0 - v2), from[3] = ivec2[3](v0, v1, v2);

  // Edge functions at the centre of the row's cell first.x; all within 32 bits for small triangles (coverage.glsl).
  int row[3], step_x[3], step_y[3], reach[3];
  PixelEdges edges;
  for (uint k = 0u; k < 3u; ++k) {
    ivec2 away = origin - from[k];
    row[k] = along[k].x * away.y - along[k].y * away.x - (edge_inclusive(along[k]) ? 0 : 1);
    step_x[k] = -along[k].y * SUBPIXEL_SNAP * cell_size.x;
    step_y[k] = along[k].x * SUBPIXEL_SNAP * cell_size.y;
    reach[k] = (abs(along[k].x) * cell_size.y + abs(along[k].y) * cell_size.x) * (SUBPIXEL_SNAP / 2);
    edges.a[k] = -float(along[k].y);
    edges.b[k] = float(along[k].x);
    row[k] -= step_y[k];
  }
  ivec2 cell = ivec2(first.x, first.y - 1);
  int row_end = first.x - 1;
  // Every turn is a cell; the rows' ends are found on the way, so that lanes do not wait for each other's rows.
  while (true) {
    if (cell.x > row_end) {
      ++cell.y;
      if (cell.y > last.y) break;
      cell.x = first.x;
      row_end = last.x;
      for (uint k = 0u; k < 3u; ++k) {
        row[k] += step_y[k];
        narrow_row(row[k] + reach[k], step_x[k], first.x, cell.x, row_end);
      }
    }
    if (cell.x <= row_end) {
      for (uint k = 0u; k < 3u; ++k)
        edges.base[k] = float(clamp((row[k] + (cell.x - first.x) * step_x[k]) >> 1, -8388608, 8388608));
      visit(cell, edges);
      ++cell.x;
    }
  }
}

#endif
