#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// variants: = STORY=-DSTORY
// Gives the fragments their dynamic blocks and links each pixel's list, lowest samples first; one invocation for each tile.
// A fragment whose place lies beyond the pool gets none.
// Reads: leaders, scanned sums with the total behind the last. Writes: all pointers of the
// pool, owners, the blocks asked for.
layout(local_size_x = 64) in;
#include "include/interface.h"
layout(constant_id = CONSTANT_SAMPLES) const uint SAMPLES = 8u;
#include "techniques/linked_list/leaders.glsl"

layout(set = 0, binding = STORAGE(LINK_SLOT_TILE_SUMS), scalar) readonly buffer Sums { uvec4 sums[]; };

#ifdef STORY
#include "techniques/linked_list/story_interface.h"
layout(set = 0, binding = STORAGE(LINK_SLOT_STORY), scalar) buffer Story {
  uvec4 told;  // pixel, places
  LinkPlace place_at[];
};
void tell_place(ivec2 pixel, uint s, uint samples, uint next, uint from) {
  for (bool tell = pixel == ivec2(told.xy); tell; tell = false) {
    place_at[told.z].of = uvec4(s, samples, next, from);
    told.z = told.z + 1u;
  }
}
#define TELL_PLACE(pixel, s, samples, next, from) tell_place(pixel, s, samples, next, from)
#else
#define TELL_PLACE(pixel, s, samples, next, from)
#endif

void main() {
  uvec2 tiles = tile_counts();
  uint tile = gl_GlobalInvocationID.x, tile_count = tiles.x * tiles.y;
  if (tile >= tile_count) return;
  if (tile == 0u) pool.allocated = sums[kLevels * tile_count].x;
  ivec2 size = ivec2(pool.width, pool.height), corner = ivec2(tile % tiles.x, tile / tiles.x) * int(LINK_TILE);
  LinkWords words = pool.words;
  uint place[LINK_MAX_SAMPLES];
  for (uint level = 0u; level < kLevels; ++level) place[level] = sums[level * tile_count + tile].x;
  for (int k = 0; k < int(LINK_TILE * LINK_TILE); ++k) {
    ivec2 pixel = corner + ivec2(k % int(LINK_TILE), k / int(LINK_TILE));
    bool inside = all(lessThan(pixel, size));
    uint leaders = texelFetch(leaders_image, min(pixel, size - 1), 0).x;
    uint from = pixel_block(pixel);
    // One after the other in the order of their samples, so that every pixel's blocks of a level follow each other.
    for (uint left = inside ? leaders & 255u : 0u; left != 0u; left &= left - 1u) {
      uint s = uint(findLSB(left));
      uint level = leader_level(leaders, s), next = 0u;
      for (uint l = 0u; l < kLevels; ++l) {
        next = l == level ? place[l] : next;
        place[l] += l == level ? 1u : 0u;
      }
      TELL_PLACE(pixel, s, leader_count(leaders, s), next, from);
      for (bool fits = next < pool.capacity; fits; fits = false) {
        uint block = first_dynamic() + next, link = make_link(block, leader_count(leaders, s), s);
        words.word[pointer_word(from)] = link;
        if (LIGHTING == LINK_LIGHT_BLOCKS) pool.owners.word[next] = make_owner(pixel, link);
        from = block;
      }
    }
    for (bool end = inside; end; end = false) words.word[pointer_word(from)] = 0u;
  }
}
