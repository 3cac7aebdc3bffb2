// What this process has done so far: processor time of all its threads, and the instructions that they retired, where
// the machine counts those and whoever started the process opened the counter for it (perf_event_open(2)).
#pragma once

#include <cstdint>

namespace subpixel {

struct WorkDone {
  double processor_ms = 0;
  std::uint64_t instructions = 0;  // in user space; 0 where they are not counted
};
WorkDone work_done();

// The descriptor that a counted process gets, and the variable of its environment that says that it has one.
constexpr int kInstructionsDescriptor = 3;
constexpr const char* kInstructionsVariable = "SUBPIXEL_INSTRUCTIONS_FD";

// Opens the counter of the calling process, of the threads that it will start and of what it executes. Returns its
// descriptor, or -1 with errno where the machine does not count or forbids it. Async-signal-safe.
int open_instruction_counter() noexcept;

}  // namespace subpixel
