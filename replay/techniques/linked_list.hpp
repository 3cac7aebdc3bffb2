// The memory of the `linked_list` technique, apart from the technique so that tests can put it between guards.
#pragma once

#include <cstdint>

#include "replay/techniques/frame_setup.hpp"

namespace subpixel::replay {

// Where the blocks lie: the pixels' own, then `dynamic_blocks` more.
struct LinkedListPool {
  gpu::Buffer* buffer = nullptr;
  std::uint64_t first_byte = 0;  // a multiple of 4
  std::uint64_t dynamic_blocks = 0;
};

// Dynamic blocks that the parameters allow: never more than pointers reach or samples could fill.
std::uint64_t linked_list_dynamic_blocks(const FrameSetup& setup);
// Bytes of a pool with that many.
std::uint64_t linked_list_pool_bytes(const FrameSetup& setup, std::uint64_t dynamic_blocks);

// All passes of the technique; counters are those of linked_list.cpp.
void record_linked_list(gpu::PassRecorder& recorder, const FrameSetup& setup, const LinkedListPool& pool);

}  // namespace subpixel::replay
