// Tells waiting progress streams that a run changed. Holds only what is not worth storing: the worker's last progress
// line. What changed is read from the store, so a stream that resumes after a restart of the service misses nothing.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

namespace subpixel::server {

class RunEvents {
 public:
  // A result was stored or the status changed.
  void changed(std::int64_t run) {
    const std::lock_guard lock(mutex_);
    ++states_[run].version;
    condition_.notify_all();
  }

  void progress(std::int64_t run, nlohmann::json progress) {
    const std::lock_guard lock(mutex_);
    State& state = states_[run];
    ++state.version;
    state.progress = std::move(progress);
    condition_.notify_all();
  }

  void clear_progress(std::int64_t run) {
    const std::lock_guard lock(mutex_);
    states_[run].progress.reset();
  }

  std::optional<nlohmann::json> progress(std::int64_t run) const {
    const std::lock_guard lock(mutex_);
    const auto found = states_.find(run);
    return found == states_.end() ? std::nullopt : found->second.progress;
  }

  std::uint64_t version(std::int64_t run) const {
    const std::lock_guard lock(mutex_);
    const auto found = states_.find(run);
    return found == states_.end() ? 0 : found->second.version;
  }

  // Returns when the run's version is not `seen` any more, after `timeout`, or at once after close().
  void wait(std::int64_t run, std::uint64_t seen, std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    condition_.wait_for(lock, timeout, [&] { return closed_ || states_[run].version != seen; });
  }

  // Wakes every waiting stream for good.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    condition_.notify_all();
  }
  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }

 private:
  struct State {
    std::uint64_t version = 0;
    std::optional<nlohmann::json> progress;
  };
  mutable std::mutex mutex_;
  std::condition_variable condition_;
  std::map<std::int64_t, State> states_;
  bool closed_ = false;
};

}  // namespace subpixel::server
