// What passes hold of the device's memory, and what they may hold.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "base/error.hpp"

namespace subpixel::gpu {

// More than the budget would be held.
class OverBudget : public DeviceError {
 public:
  OverBudget(const std::string& name, std::uint64_t held, std::uint64_t budget)
      : DeviceError("memory",
                    std::to_string(held) + " bytes would be over the budget of " + std::to_string(budget) + " bytes",
                    name),
        name_(name) {}
  const std::string& name() const { return name_; }  // of the buffer or image

 private:
  std::string name_;
};

// Buffers and images of PassRecorders, all together. What a device holds without them (the scene, its shadow map, the
// front-end's triangles) is not in it.
class MemoryLedger {
 public:
  // Nothing: no limit.
  void set_budget(std::optional<std::uint64_t> bytes) { budget_ = bytes; }
  std::optional<std::uint64_t> budget() const { return budget_; }

  // Throws OverBudget, and then holds nothing of it.
  void hold(const std::string& name, std::uint64_t bytes) {
    require(name, bytes);
    held_ += bytes;
  }
  void release(std::uint64_t bytes) { held_ -= bytes; }
  // Of what is held for a moment later on: throws OverBudget where that will not fit beside what is held now.
  void require(const std::string& name, std::uint64_t bytes) {
    if (budget_ && held_ + bytes > *budget_) throw OverBudget(name, held_ + bytes, *budget_);
    peak_ = std::max(peak_, held_ + bytes);
  }

  // The most that was held or required since the last reset.
  std::uint64_t peak() const { return peak_; }
  void reset_peak() { reset_peak(0); }
  // As if since then no more than `peak` had been held, or what is held now.
  void reset_peak(std::uint64_t peak) { peak_ = std::max(peak, held_); }

 private:
  std::optional<std::uint64_t> budget_;
  std::uint64_t held_ = 0, peak_ = 0;
};

}  // namespace subpixel::gpu
