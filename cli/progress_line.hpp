// How far something is, on standard error.
#pragma once

#include <cstdint>
#include <string>

namespace subpixel::cli {

// One line that is redrawn on a terminal, and a line for each change of what is being done in a log.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // `done` of `total` steps of `stage`; `detail` says what the step is of.
  void update(const std::string& stage, std::uint64_t done, std::uint64_t total, const std::string& detail);

 private:
  const bool terminal_;
  std::string last_;
};

}  // namespace subpixel::cli
