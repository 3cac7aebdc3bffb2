// The whole service over one data folder: store, job queue, HTTP. `subpixel serve` and the tests run it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/http_server.hpp"
#include "server/job_queue.hpp"

namespace subpixel::server {

struct ServiceOptions {
  std::filesystem::path data;
  std::string host = "127.0.0.1";
  int port = 8080;  // 0: any free one
  // Names other than IP addresses and localhost by which clients may call the service (see check_origin in api.cpp).
  std::vector<std::string> host_names;
  bool require_token = false;  // for everything but the viewer's files (server/routes.hpp has what needs which right)
  bool log_requests = false;
  std::uint64_t upload_limit_bytes = std::uint64_t{4} << 30;
  std::uint64_t reserved_bytes = std::uint64_t{64} << 20;  // free space an upload must leave, so that results still fit
  WorkerOptions worker;
  HttpLimits http;
};

class Service {
 public:
  // Opens the data folder and binds the address. Throws InputError for the folder, UsageError for the address.
  explicit Service(ServiceOptions options);
  ~Service();

  // The port that was bound.
  int port() const;
  // Resumes unfinished runs, then serves until stop(). Returns after the last worker has ended.
  void run();
  // Makes run() return. Callable from any thread.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace subpixel::server
