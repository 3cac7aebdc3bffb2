// `subpixel import` reads models in a process of its own (this program with the verb import-worker): readers of other
// people's formats crash, hang and take memory without end on some files.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/renderdoc_import.hpp"
#include "scenes/import/import.hpp"

namespace subpixel::cli {

struct ImportLimits {
  std::chrono::seconds duration{300};     // 0: none
  std::uint64_t address_space_bytes = 0;  // 0: none
  bool is_confined = true;                // docs/operations.md
};

// Three quarters of the machine's memory, at most 8 GiB; none where a sanitizer needs more address space than there is
// memory.
std::uint64_t default_import_address_space();

// Imports `in` by a child process that gets `options`, verbatim, and reports progress on standard error. `out` is there
// when it is whole, else as it was before. Prints what was written. Throws what the child reports, and InputError when
// it crashed or reached a limit. Ends this process as SIGINT, SIGTERM and SIGHUP do, with nothing left behind.
void import_in_child(const std::string& in, const std::filesystem::path& out, const std::vector<std::string>& options,
                     const ImportLimits& limits);

// What the child does: imports and writes `out`. Messages go to standard output, a JSON document a line:
// {"type": "progress", "text"}, then {"type": "done", "summary"} or {"type": "error", "text"}. Returns the exit code.
int import_worker(const std::string& in, const std::filesystem::path& out, capture::ImportOptions options,
                  const RenderDocOptions& renderdoc = {});

}  // namespace subpixel::cli
