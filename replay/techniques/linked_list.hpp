// The memory of the `linked_list` technique, apart from the technique so that tests can put it between guards.
#pragma once

#include <cstdint>

#include "replay/frame/technique.hpp"
#include "shaders/techniques/linked_list/linked_list_interface.h"

namespace subpixel::replay {

enum class PoolUnit { blocks_per_pixel, mib, blocks };
// The next two have the values of the specialization constants.
enum class BlockAllocation : std::uint32_t {
  largest = LINK_ALLOCATE_LARGEST,
  tiles = LINK_ALLOCATE_TILES,
  atomic = LINK_ALLOCATE_ATOMIC,
};
enum class FirstBlock : std::uint32_t { sample = LINK_FIRST_SAMPLE, covered = LINK_FIRST_COVERED };
enum class BlockLighting { blocks, lists };

struct LinkedListParameters : CommonParameters {
  double pool = LINK_MAX_SAMPLES - 1;  // in its unit
  PoolUnit pool_unit = PoolUnit::blocks_per_pixel;
  BlockAllocation allocation = BlockAllocation::largest;
  FirstBlock first_block = FirstBlock::sample;
  BlockLighting lighting = BlockLighting::blocks;
};
using LinkedListSetup = SetupFor<LinkedListParameters>;

// Where the blocks lie: the pixels' own, then `dynamic_blocks` more.
struct LinkedListPool {
  gpu::Buffer* buffer = nullptr;
  std::uint64_t first_byte = 0;  // a multiple of 4
  std::uint64_t dynamic_blocks = 0;
};

// Dynamic blocks that the parameters allow: never more than pointers reach or samples could fill.
std::uint64_t linked_list_dynamic_blocks(const LinkedListSetup& setup);
// Bytes of a pool with that many.
std::uint64_t linked_list_pool_bytes(const LinkedListSetup& setup, std::uint64_t dynamic_blocks);

// All passes of the technique; counters are those of linked_list.cpp.
void record_linked_list(gpu::PassRecorder& recorder, const LinkedListSetup& setup, const LinkedListPool& pool);

}  // namespace subpixel::replay
