#include "server/service.hpp"

#include <fmt/format.h>

#include <cstdint>

#include "base/error.hpp"
#include "server/api.hpp"
#include "server/store/data_folder.hpp"

namespace subpixel::server {

struct Service::State {
  explicit State(ServiceOptions given)
      : options(std::move(given)),
        folder(options.data),
        store(folder.store()),
        http(options.http, folder.uploads()),
        events([this](std::int64_t run) { http.changed(run); }),
        queue(store, folder, events, options.worker),
        api(options, folder, store, events, queue) {}

  ServiceOptions options;
  DataFolder folder;
  Store store;
  HttpServer http;
  RunEvents events;
  JobQueue queue;
  Api api;
  int port = 0;
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
  s.queue.start();
  s.api.serve(s.http);
  s.queue.stop();
}

void Service::stop() {
  State& s = *state_;
  s.api.stop();
  s.http.shut_down();
}

}  // namespace subpixel::server
