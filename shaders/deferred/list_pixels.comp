#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Writes the flagged pixels of each tile to their place in the list; one invocation for each tile.
// Reads: flags, scanned sums with the total behind the last tile. Writes: the list, and the workgroups that work
// through it.
layout(local_size_x = 64) in;
#include "deferred/pixel_list.glsl"

layout(set = 0, binding = SAMPLED(DEFERRED_SLOT_FLAGS)) uniform usampler2D flags;
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_TILE_SUMS), scalar) readonly buffer Sums { uvec4 sums[]; };
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_PIXEL_LIST), scalar) writeonly buffer List {
  uint listed;
  uint list[];
};
layout(set = 0, binding = STORAGE(DEFERRED_SLOT_GROUPS), scalar) writeonly buffer Groups { uint groups[3]; };

void main() {
  ivec2 size = textureSize(flags, 0);
  uvec2 tiles = (uvec2(size) + kTile - 1u) / kTile;
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= tiles.x * tiles.y) return;
  ivec2 corner = ivec2(tile % tiles.x, tile / tiles.x) * int(kTile);
  uint place = sums[tile].x;
  for (int k = 0; k < int(kTile * kTile); ++k) {
    ivec2 pixel = corner + ivec2(k % int(kTile), k / int(kTile));
    uint flag = texelFetch(flags, min(pixel, size - 1), 0).x;
    if (all(lessThan(pixel, size)) && flag != 0u) list[place++] = uint(pixel.x) | uint(pixel.y) << 16;
  }
  if (tile == 0u) {
    uint total = sums[tiles.x * tiles.y].x;
    uint count = (total + kPixelGroup - 1u) / kPixelGroup;
    listed = total;
    groups[0] = min(count, kRowGroups);
    groups[1] = (count + kRowGroups - 1u) / kRowGroups;
    groups[2] = 1u;
  }
}
