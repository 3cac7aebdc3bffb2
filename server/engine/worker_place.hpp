// Where a worker process is, by what it says, for when it dies and can't say any more: drivers crash on some machines
// and not on others, and whoever reads of it has to know at what, with which driver, and what to do about it.
#pragma once

#include <string>
#include <string_view>

#include "process/child_process.hpp"

namespace subpixel::server {

class WorkerPlace {
 public:
  // Of a "progress" message. The stage "device" names the device and its driver.
  void progress(std::string_view stage, std::string_view detail);
  // Why the process ended, in one line; empty when it ended well or was stopped. After a signal besides the outcome's
  // reason: what the worker was at, with which driver, and what to try. Then its last words on standard error.
  std::string end_in_words(const ChildOutcome& outcome) const;

 private:
  std::string at_, device_;
};

}  // namespace subpixel::server
