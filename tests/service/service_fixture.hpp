// A service of the test's own: a fresh data folder, the fake worker, a free port.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/service.hpp"

namespace subpixel::tests {

using nlohmann::json;

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The service's options for `data` with the fake worker and limits short enough for tests.
server::ServiceOptions test_options(const std::filesystem::path& data);

// A capture for the fake worker; `behaviour` is described in fake_worker/main.cpp.
std::string fake_capture(const json& behaviour);

// What is sent and received in words of this API.
class Client {
 public:
  explicit Client(int port);
  httplib::Client& http() { return http_; }

  httplib::Result upload(const std::string& bytes, const std::string& name = "test.spcap");
  // Uploads and returns the hash; fails the test when it is refused.
  std::string upload_fake(const json& behaviour);
  httplib::Result post_run(const json& body);
  // Starts a run of `noaa` and `msaa` over all frames and returns its number.
  std::int64_t start_run(const std::string& capture);
  json get(const std::string& path, int expected_status = 200);
  // Polls until the run's status is final.
  json wait_for_end(std::int64_t run, std::chrono::seconds timeout = std::chrono::seconds(30));

 private:
  httplib::Client http_;
};

// The service on a thread of this process.
class RunningService {
 public:
  explicit RunningService(server::ServiceOptions options);
  ~RunningService();
  int port() const { return service_.port(); }

 private:
  server::Service service_;
  std::thread thread_;
};

// The service as a process of its own: `subpixel serve` over `data`, with the fake worker.
class ServiceProcess {
 public:
  explicit ServiceProcess(const std::filesystem::path& data,
                          const std::vector<std::string>& options = {"--listen", "127.0.0.1:0"});
  ~ServiceProcess();
  ServiceProcess(const ServiceProcess&) = delete;
  ServiceProcess& operator=(const ServiceProcess&) = delete;

  int port() const { return port_; }
  int id() const { return pid_; }
  // Sends the signal, waits for the end and returns the exit code, -1 for an end by a signal.
  int end(int signal);
  // Kills its workers and inspections as SIGKILL does. Returns how many there were.
  int kill_children() const;

 private:
  int pid_ = -1;
  int port_ = 0;
};

class ServiceTest : public testing::Test {
 protected:
  // Called with changed options before the first request, where a test needs them.
  void start(const server::ServiceOptions& options);
  server::ServiceOptions options() const { return test_options(folder_.path() / "data"); }
  Client& client();
  int port() const { return service_->port(); }
  const std::filesystem::path& folder() const { return folder_.path(); }
  void stop() { service_.reset(); }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<RunningService> service_;
  std::unique_ptr<Client> client_;
};

// Sends raw bytes over a connection of its own and returns all that comes back until the other side closes.
std::string raw_exchange(int port, const std::string& bytes, bool finish_sending = false);

// The "error" member of an answer; fails the test when it has not the documented form.
json error_of(const httplib::Result& result, int expected_status);

}  // namespace subpixel::tests
