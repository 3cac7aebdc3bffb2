#include "cli/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "base/printable.hpp"

namespace subpixel::cli {

ProgressLine::ProgressLine() : terminal_(::isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  if (terminal_ && !last_.empty()) fmt::print(stderr, "\r\033[K");
}

void ProgressLine::update(const std::string& stage, std::uint64_t done, std::uint64_t total,
                          const std::string& detail) {
  const std::string label = printable(stage + " " + detail);
  if (terminal_) {
    constexpr std::uint64_t kWidth = 30;
    const std::uint64_t filled = total == 0 ? kWidth : std::min(done, total) * kWidth / total;
    fmt::print(stderr, "\r\033[K[{}{}] {}/{} {}", std::string(filled, '#'), std::string(kWidth - filled, '.'), done,
               total, label);
    std::fflush(stderr);
  } else if (label != last_) {
    fmt::print(stderr, "{}: {} ({}/{})\n", printable(stage), printable(detail), done, total);
  }
  last_ = label;
}

}  // namespace subpixel::cli
