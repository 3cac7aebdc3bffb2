// What is known of running runs and not worth storing: the worker's last progress line. Says that a run changed to
// whoever tells its followers; what changed is read from the store, so that one who comes back after a restart of the
// service misses nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

namespace subpixel::server {

class RunEvents {
 public:
  // `on_change` is called from any thread, after what it is about.
  explicit RunEvents(std::function<void(std::int64_t run)> on_change) : on_change_(std::move(on_change)) {}

  // A result was stored or the status changed.
  void changed(std::int64_t run) { on_change_(run); }

  void progress(std::int64_t run, nlohmann::json progress) {
    {
      const std::lock_guard lock(mutex_);
      progress_[run] = std::move(progress);
    }
    on_change_(run);
  }

  void clear_progress(std::int64_t run) {
    const std::lock_guard lock(mutex_);
    progress_.erase(run);
  }

  std::optional<nlohmann::json> progress(std::int64_t run) const {
    const std::lock_guard lock(mutex_);
    const auto found = progress_.find(run);
    return found == progress_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::function<void(std::int64_t)> on_change_;
  mutable std::mutex mutex_;
  std::map<std::int64_t, nlohmann::json> progress_;
};

}  // namespace subpixel::server
