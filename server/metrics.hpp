// What the service counts of its requests, in the text format of Prometheus.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace subpixel::server {

// A label's value, or a line of help, as the format wants it.
std::string metric_text(const std::string& text);

class Metrics {
 public:
  // One answered request: its operation of the table, what was answered, how long the answer took to make, the bytes of
  // its body that came. From any thread.
  void count(const std::string& operation, int status, double seconds, std::uint64_t received_bytes);
  std::string text() const;

 private:
  static constexpr std::array<double, 12> kBounds{0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 10};
  struct Histogram {
    std::array<std::uint64_t, kBounds.size()> upto{};  // not cumulated
    std::uint64_t count = 0;
    double sum = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> requests_;
  std::map<std::string, Histogram> seconds_;
  std::uint64_t received_bytes_ = 0;
};

}  // namespace subpixel::server
