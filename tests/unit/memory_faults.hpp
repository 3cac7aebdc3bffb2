// Memory that runs out when a test says so.
#pragma once

#include <cstdint>

namespace subpixel::tests {

// While it lives, the allocation of this thread after `allocations` more of them throws std::bad_alloc, once.
class MemoryFault {
 public:
  explicit MemoryFault(std::int64_t allocations);
  ~MemoryFault();
  MemoryFault(const MemoryFault&) = delete;
  MemoryFault& operator=(const MemoryFault&) = delete;
};

}  // namespace subpixel::tests
