// What a child process may still do: read what it is told to and the system's libraries, write in its own folders, and
// compute. Landlock (kernel 5.13) holds the file system, TCP and signals, seccomp the system calls.
#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <string>
#include <vector>

namespace subpixel {

struct Confinement {
  std::vector<std::string> readable;  // files, and folders with all in them, besides the system's libraries and data
  std::vector<std::string> writable;  // the same, to make, change and remove in too
  // An interpreter that it may start, besides processes and the programs of /usr, all confined alike: the import of
  // RenderDoc captures runs Python. Empty: no further process and no program but its own.
  std::string interpreter{};
};

// A confinement made ready before a fork, for what comes between it and exec must neither allocate nor lock.
class PreparedConfinement {
 public:
  // `program` is what the child will execute. Throws std::runtime_error when libseccomp can't make the filter.
  PreparedConfinement(const Confinement& confinement, const std::string& program);

  // Confines the calling process for good, as far as the kernel can (confinement_gaps). False: it is not confined and
  // must not go on. Async-signal-safe.
  bool enter() const noexcept;

 private:
  struct Rule {
    std::string path;
    std::uint64_t access;
  };
  bool enter_landlock() const noexcept;

  int landlock_version_;
  std::vector<Rule> rules_;
  std::vector<sock_filter> filter_;  // empty where the kernel has no seccomp filters
};

// From here on this process can't become another program. For programs that decode what others made, once they run:
// whoever confined them could not forbid it yet.
void forbid_programs();

// What this kernel can't hold a confined process to, a sentence each; empty when it is all there.
std::vector<std::string> confinement_gaps();

}  // namespace subpixel
