#include "base/work_counter.hpp"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>

namespace subpixel {
namespace {

bool has_counter() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing of ours changes the environment
  static const bool has = std::getenv(kInstructionsVariable) != nullptr;
  return has;
}

}  // namespace

int open_instruction_counter() noexcept {
  perf_event_attr event{};
  event.size = sizeof(event);
  event.type = PERF_TYPE_HARDWARE;
  event.config = PERF_COUNT_HW_INSTRUCTIONS;
  event.inherit = 1;
  event.exclude_kernel = 1;
  event.exclude_hv = 1;
  return static_cast<int>(::syscall(SYS_perf_event_open, &event, 0, -1, -1, 0));
}

WorkDone work_done() {
  WorkDone work;
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  work.processor_ms = static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  std::uint64_t count = 0;
  if (has_counter() && ::read(kInstructionsDescriptor, &count, sizeof(count)) == sizeof(count))
    work.instructions = count;
  return work;
}

}  // namespace subpixel
