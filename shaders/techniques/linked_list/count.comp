#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// Counts the dynamic blocks that each tile of pixels needs, by level; one invocation for each tile.
// Reads: leaders. Writes: sums, level by level, the tiles of each in a row; x is to be scanned in place.
layout(local_size_x = 64) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/linked_list/leaders.glsl"

layout(set = 0, binding = STORAGE(LINK_SLOT_TILE_SUMS), scalar) writeonly buffer Sums { uvec4 sums[]; };

void main() {
  uvec2 tiles = tile_counts();
  uint tile = gl_GlobalInvocationID.x, tile_count = tiles.x * tiles.y;
  if (tile >= tile_count) return;
  ivec2 size = ivec2(pool.width, pool.height), corner = ivec2(tile % tiles.x, tile / tiles.x) * int(LINK_TILE);
  uint needed[LINK_MAX_SAMPLES];
  for (uint level = 0u; level < kLevels; ++level) needed[level] = 0u;
  for (int k = 0; k < int(LINK_TILE * LINK_TILE); ++k) {
    ivec2 pixel = corner + ivec2(k % int(LINK_TILE), k / int(LINK_TILE));
    uint leaders = texelFetch(leaders_image, min(pixel, size - 1), 0).x;
    for (uint left = all(lessThan(pixel, size)) ? leaders & 255u : 0u; left != 0u; left &= left - 1u) {
      uint own_level = leader_level(leaders, uint(findLSB(left)));
      for (uint level = 0u; level < kLevels; ++level) needed[level] += own_level == level ? 1u : 0u;
    }
  }
  for (uint level = 0u; level < kLevels; ++level) sums[level * tile_count + tile] = uvec4(needed[level], 0u, 0u, 0u);
}
