#include "tests/unit/memory_faults.hpp"

#include <cstdlib>
#include <new>

namespace {

constexpr std::int64_t kNoFault = -1;
thread_local std::int64_t left = kNoFault;  // allocations before the one that fails

}  // namespace

namespace subpixel::tests {

MemoryFault::MemoryFault(std::int64_t allocations) {
  left = allocations;
}
MemoryFault::~MemoryFault() {
  left = kNoFault;
}

}  // namespace subpixel::tests

// The program's: [new.delete.single] lets it have its own, and the other forms call these.
void* operator new(std::size_t size) {
  if (left != kNoFault && left-- == 0) throw std::bad_alloc();
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
