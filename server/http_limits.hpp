// What clients of the service may take of it.
#pragma once

#include <chrono>
#include <cstddef>

namespace subpixel::server {

struct HttpLimits {
  std::size_t header_line_bytes = 4096;           // request line included
  std::size_t header_bytes = 32768;               // all of a request's header
  std::chrono::milliseconds header_time{10'000};  // from a request's first byte to its header's end
  std::chrono::milliseconds idle_time{30'000};    // between requests, and without a byte within a body or response
  std::size_t connections = 4096;                 // at a time; for more the idlest are closed
  std::size_t followers = 2048;                   // of runs, at a time
  // Threads that answer: requests without a body, and pieces of bodies that go to the disk; and requests with one,
  // among them uploads, which wait for a process that reads the capture.
  std::size_t threads = 8, body_threads = 16;
};

}  // namespace subpixel::server
