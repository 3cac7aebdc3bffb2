// cpp-httplib's server behind limits of our own. The library (0.11) reads header lines of any length and number into
// memory and sets no time limit on a whole request; connections here pass through a stream that does.
#pragma once

#include <httplib.h>

#include <chrono>
#include <cstddef>
#include <string>

namespace subpixel::server {

struct HttpLimits {
  std::size_t header_line_bytes = 4096;           // request line included
  std::size_t header_bytes = 32768;               // all of a request's header
  std::chrono::milliseconds header_time{10'000};  // from a request's first byte to its header's end
  std::chrono::milliseconds idle_time{30'000};    // between requests, and without a byte within a body or response
  std::size_t connections = 64;                   // at a time, each with a thread; more wait
};

class HttpServer : public httplib::Server {
 public:
  explicit HttpServer(const HttpLimits& limits);
  // Makes waiting connections end soon; then stops accepting.
  void shut_down();
  bool shutting_down() const { return shutting_down_; }

 private:
  bool process_and_close_socket(socket_t socket) override;

  HttpLimits limits_;
  std::atomic<bool> shutting_down_{false};
};

}  // namespace subpixel::server
