#include "server/service.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "base/error.hpp"
#include "server/api.hpp"
#include "server/store/data_folder.hpp"

namespace subpixel::server {

struct Service::State {
  explicit State(ServiceOptions given)
      : options(std::move(given)),
        folder(options.data),
        store(folder.store()),
        queue(store, folder, events, options.worker),
        http(options.http),
        api(options, folder, store, events, queue) {}

  ServiceOptions options;
  DataFolder folder;
  Store store;
  RunEvents events;
  JobQueue queue;
  HttpServer http;
  Api api;
  int port = 0;
  std::mutex mutex;  // guards the next two
  bool started = false, stop_requested = false;
  std::atomic<bool> ended{false};  // listening is over
};

Service::Service(ServiceOptions options) : state_(std::make_unique<State>(std::move(options))) {
  State& s = *state_;
  s.api.route(s.http);
  const std::string& host = s.options.host;
  s.port = s.options.port;
  const bool bound = s.port == 0 ? (s.port = s.http.bind_to_any_port(host)) > 0 : s.http.bind_to_port(host, s.port);
  if (!bound) {
    throw UsageError("can't listen", "the address is in use or not one of this machine's",
                     fmt::format("{}:{}", host, s.options.port));
  }
}

Service::~Service() = default;

int Service::port() const {
  return state_->port;
}

void Service::run() {
  State& s = *state_;
  {
    const std::lock_guard lock(s.mutex);
    if (s.stop_requested) return;
    s.started = true;
  }
  s.queue.start();
  s.http.listen_after_bind();
  s.ended = true;
  s.events.close();
  s.queue.stop();
}

void Service::stop() {
  State& s = *state_;
  {
    const std::lock_guard lock(s.mutex);
    s.stop_requested = true;
    if (!s.started) return;
  }
  s.api.stop();
  s.events.close();
  // The library forgets a stop that comes before it listens.
  while (!s.http.is_running() && !s.ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  s.http.shut_down();
}

}  // namespace subpixel::server
