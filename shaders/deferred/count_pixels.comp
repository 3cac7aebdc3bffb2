#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Counts the flagged pixels of each tile; one invocation for each tile.
// Reads: flags. Writes: sums (x: the count, to be scanned in place), counts (the same, which stay).
layout(local_size_x = 64) in;
#include "deferred/pixel_list.glsl"

layout(set = 0, binding = SAMPLED(DEFERRED_SLOT_FLAGS)) uniform usampler2D flags;
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_TILE_SUMS), scalar) writeonly buffer Sums { uvec4 sums[]; };
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_TILE_COUNTS), scalar) writeonly buffer Counts { uint counts[]; };

void main() {
  ivec2 size = textureSize(flags, 0);
  uvec2 tiles = (uvec2(size) + kTile - 1u) / kTile;
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= tiles.x * tiles.y) return;
  ivec2 corner = ivec2(tile % tiles.x, tile / tiles.x) * int(kTile);
  uint count = 0u;
  for (int k = 0; k < int(kTile * kTile); ++k) {
    ivec2 pixel = corner + ivec2(k % int(kTile), k / int(kTile));
    uint flag = texelFetch(flags, min(pixel, size - 1), 0).x;
    count += all(lessThan(pixel, size)) && flag != 0u ? 1u : 0u;
  }
  sums[tile] = uvec4(count, 0u, 0u, 0u);
  counts[tile] = count;
}
