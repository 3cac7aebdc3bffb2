#include "server/http_server.hpp"

#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>
#include <utility>

#include "base/log_fields.hpp"
#include "base/numbers.hpp"

namespace subpixel::server {
namespace {

// An answer to a larger body may come before it was read, which ends the connection, so its header says so beforehand.
constexpr std::uint64_t kSmallBodyBytes = 65536;

// The length of the body that follows a header, 0 without one; nothing when it can't be told. What follows such a
// header must not be read, neither as a body nor as the next request.
std::optional<std::uint64_t> declared_length(const httplib::Request& request) {
  if (request.has_header("Transfer-Encoding")) return std::nullopt;
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  if (lengths != 1) return lengths == 0 ? std::optional<std::uint64_t>(0) : std::nullopt;
  return parse_number<std::uint64_t>(request.get_header_value("Content-Length"));
}

// A target that is a whole address (RFC 9112, section 3.2.2) becomes its path, and its authority the Host, whatever
// that was: what is checked is what was asked for. Such a request too must have said one Host.
void take_absolute_form(httplib::Request& request) {
  constexpr std::string_view kScheme = "http://";
  const std::string& target = request.target;
  if (target.size() < kScheme.size() || ::strncasecmp(target.data(), kScheme.data(), kScheme.size()) != 0) return;
  const std::size_t end = std::min(target.find_first_of("/?", kScheme.size()), target.size());
  if (request.get_header_value_count("Host") == 1) {
    request.headers.erase("Host");
    request.headers.emplace("Host", target.substr(kScheme.size(), end - kScheme.size()));
  }
  const bool rooted = end < target.size() && target[end] == '/';
  const std::string rest = std::string(rooted ? "" : "/").append(target, end);
  request.path = httplib::detail::decode_url(rest.substr(0, rest.find('?')), false);
  request.target = rest;
}

// Nothing that could break a line of the log.
bool is_id(std::string_view text) {
  constexpr std::size_t kMaxBytes = 64;
  return !text.empty() && text.size() <= kMaxBytes && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  });
}

}  // namespace

HttpServer::HttpServer(const HttpLimits& limits, std::filesystem::path spill_folder)
    : connections_(limits, std::move(spill_folder)) {
  set_tcp_nodelay(true);
  // The library's default is SO_REUSEPORT, with which two servers share a port in silence.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
}

HttpServer::~HttpServer() {
  if (svr_sock_ != INVALID_SOCKET) ::close(svr_sock_);
}

void HttpServer::serve(OpenBody open_body, NewsSource news, std::string heartbeat) {
  connections_.run(svr_sock_, {.answer = [this](Exchange& exchange) { answer(exchange); },
                               .news = std::move(news),
                               .open_body = std::move(open_body),
                               .heartbeat = std::move(heartbeat)});
  // Not before: without it the library takes itself for ended, and sends no content.
  ::close(svr_sock_.exchange(INVALID_SOCKET));
}

void HttpServer::answer(Exchange& exchange) {
  const LogField request("request", exchange.id());
  exchange.run([&](bool last_of_connection, bool& closed) {
    return process_request(exchange, last_of_connection, closed, [&](httplib::Request& parsed) {
      const std::optional<std::uint64_t> length = declared_length(parsed);
      const bool expects_continue = parsed.get_header_value("Expect") == "100-continue";
      if (const std::string given = parsed.get_header_value("X-Request-Id"); is_id(given)) {
        exchange.set_id(given);
        log_fields().back().second = given;
      }
      if (exchange.body_has_come()) parsed.headers.erase("Expect");
      // The library did not see them: its own are not bounded in number, and its answer to malformed ones is in parts.
      for (const std::string& range : exchange.ranges()) parsed.headers.emplace("Range", range);
      take_absolute_form(parsed);
      const bool last = !length || *length > kSmallBodyBytes || parsed.version == "HTTP/1.0";
      if (last) {
        parsed.headers.erase("Connection");
        parsed.set_header("Connection", "close");
      }
      exchange.frame(length.value_or(0), expects_continue, last);
    });
  });
}

}  // namespace subpixel::server
