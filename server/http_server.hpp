// cpp-httplib's reading of requests, its routes and its writing of answers, without its connections: the library (0.11)
// has a thread for each, so that slow clients hold up all others, and reads headers of any length and number.
#pragma once

#include <httplib.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "server/http_connections.hpp"
#include "server/http_exchange.hpp"
#include "server/http_limits.hpp"

namespace subpixel::server {

class HttpServer : public httplib::Server {
 public:
  using NewsSource = std::function<std::optional<News>(std::int64_t topic, std::int64_t position)>;

  // Answers too large for memory wait for their clients in `spill_folder`.
  HttpServer(const HttpLimits& limits, std::filesystem::path spill_folder);
  ~HttpServer() override;
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Serves the address that was bound until shut_down(), which may come before.
  void serve(OpenBody open_body, NewsSource news, std::string heartbeat);
  void shut_down() { connections_.stop(); }
  // Answers one request, on the calling thread: serve()'s part without the connections.
  void answer(Exchange& exchange);
  // Followers of the topic are to get news. From any thread.
  void changed(std::int64_t topic) { connections_.changed(topic); }

 private:
  HttpConnections connections_;
};

}  // namespace subpixel::server
