// Where a replay's wall time outside of device passes goes: a stopwatch with one part running at a time.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <utility>

namespace subpixel::replay {

class HostClock {
 public:
  // Starts with `part`.
  explicit HostClock(std::string part) : part_(std::move(part)) {}

  // Ends the running part and starts `part`, which may have run before. `device_ms`: all that the device took since the
  // clock was made, which no part counts. Returns the part that ended.
  std::string enter(std::string part, double device_ms) {
    const Time now = Clock::now();
    seconds_[part_] += std::chrono::duration<double>(now - since_).count() - (device_ms - device_ms_) * 1e-3;
    since_ = now;
    device_ms_ = device_ms;
    return std::exchange(part_, std::move(part));
  }

  // Of the parts that ended.
  const std::map<std::string, double>& seconds() const { return seconds_; }
  // Since the clock was made, the device's time with it.
  double wall_s() const { return std::chrono::duration<double>(since_ - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;
  Time start_ = Clock::now(), since_ = start_;
  std::string part_;
  double device_ms_ = 0;
  std::map<std::string, double> seconds_;
};

}  // namespace subpixel::replay
