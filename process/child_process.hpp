// One child process, watched: its standard output line by line, the tail of its standard error, and limits on silence,
// duration, line length and what it may take, and where it may go (confinement.hpp). What it runs may crash, hang or
// write garbage; the caller gets a reason.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "process/confinement.hpp"

namespace subpixel {

struct ChildLimits {
  std::chrono::milliseconds silence{std::chrono::minutes(10)};  // longest wait for the next line of standard output
  std::chrono::milliseconds duration{std::chrono::hours(12)};
  std::size_t line_bytes = std::size_t{8} << 20;
  // 0: none, and never more than this process has itself.
  std::uint64_t address_space_bytes = 0;
  std::uint64_t file_bytes = 0;   // of each file it writes
  std::uint64_t processor_s = 0;  // of all its threads together
  std::optional<Confinement> confinement;
  std::vector<std::string> environment;  // NAME=VALUE, added to this process's
  bool counts_instructions = false;      // the child may ask what it retired (base/work_counter.hpp)
};

struct ChildOutcome {
  enum class Kind { exited, signalled, silent, too_long, line_too_long, stopped, refused, not_started };
  Kind kind = Kind::exited;
  int code = 0;            // exit code or signal number
  std::string error_tail;  // last bytes of standard error
  std::string reason;      // empty for exit code 0 and for `stopped`; else one sentence for people
};

// Takes a line without its newline. Returning false ends the child (outcome `refused`).
using LineHandler = std::function<bool(std::string_view line)>;

// Runs `arguments` (the program's path first) in a process group of its own until it ends or a limit is reached; then
// the whole group is killed. The child also dies with this process, even by SIGKILL, as long as the calling thread
// lives.
ChildOutcome run_child(const std::vector<std::string>& arguments, const ChildLimits& limits, std::stop_token stop,
                       const LineHandler& on_line);

}  // namespace subpixel
