#include "server/metrics.hpp"

#include <fmt/format.h>

namespace subpixel::server {

std::string metric_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\' || c == '"') out += '\\';
    out += c == '\n' ? std::string("\\n") : std::string(1, c);
  }
  return out;
}

void Metrics::count(const std::string& operation, int status, double seconds, std::uint64_t received_bytes) {
  const std::lock_guard lock(mutex_);
  ++requests_[{operation, status}];
  received_bytes_ += received_bytes;
  Histogram& histogram = seconds_[operation];
  ++histogram.count;
  histogram.sum += seconds;
  for (std::size_t i = 0; i < kBounds.size(); ++i) {
    if (seconds > kBounds[i]) continue;
    ++histogram.upto[i];
    break;
  }
}

std::string Metrics::text() const {
  const std::lock_guard lock(mutex_);
  std::string out =
      "# HELP subpixel_http_requests_total Requests answered.\n# TYPE subpixel_http_requests_total counter\n";
  for (const auto& [key, number] : requests_) {
    out += fmt::format("subpixel_http_requests_total{{operation=\"{}\",status=\"{}\"}} {}\n", metric_text(key.first),
                       key.second, number);
  }
  out +=
      "# HELP subpixel_http_request_seconds Time an answer took to make, without sending it.\n"
      "# TYPE subpixel_http_request_seconds histogram\n";
  for (const auto& [operation, histogram] : seconds_) {
    const std::string label = metric_text(operation);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kBounds.size(); ++i) {
      sum += histogram.upto[i];
      out += fmt::format("subpixel_http_request_seconds_bucket{{operation=\"{}\",le=\"{}\"}} {}\n", label, kBounds[i],
                         sum);
    }
    out += fmt::format(
        "subpixel_http_request_seconds_bucket{{operation=\"{0}\",le=\"+Inf\"}} {1}\n"
        "subpixel_http_request_seconds_sum{{operation=\"{0}\"}} {2}\n"
        "subpixel_http_request_seconds_count{{operation=\"{0}\"}} {1}\n",
        label, histogram.count, histogram.sum);
  }
  out += fmt::format(
      "# HELP subpixel_http_received_bytes_total Bytes of bodies of answered requests.\n"
      "# TYPE subpixel_http_received_bytes_total counter\nsubpixel_http_received_bytes_total {}\n",
      received_bytes_);
  return out;
}

}  // namespace subpixel::server
