// What all routes share: limits, the defence against other sites, headers, health, the viewer's files.
#include "server/api.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/numbers.hpp"
#include "replay/measure/maps.hpp"
#include "replay/results/limits.hpp"
#include "replay/techniques/registry.hpp"
#include "server/http_error.hpp"
#include "server/upload.hpp"
#include "web/embedded.hpp"

namespace subpixel::server {
namespace {

constexpr std::uint64_t kMaxOtherBodyBytes = 1 << 20;

bool is_reading(const httplib::Request& request) {
  return request.method == "GET" || request.method == "HEAD";
}

// The length of a request's body, 0 without a Content-Length. Throws HttpError 400 for one that is no number.
std::uint64_t content_length(const httplib::Request& request) {
  if (!request.has_header("Content-Length")) return 0;  // RFC 9112, section 6.3: no length, no body
  const auto length = parse_number<std::uint64_t>(request.get_header_value("Content-Length"));
  if (!length) {
    throw HttpError(400, "the request is malformed", "Content-Length is no number", "header Content-Length");
  }
  return *length;
}

}  // namespace

std::int64_t query_number(const httplib::Request& request, const std::string& name, std::int64_t minimum,
                          std::int64_t maximum, std::int64_t absent) {
  if (!request.has_param(name)) return absent;
  const auto number = parse_number<std::int64_t>(request.get_param_value(name));
  if (!number || *number < minimum || *number > maximum) {
    throw HttpError(400, "the query is wrong", fmt::format("expected a whole number from {} to {}", minimum, maximum),
                    name);
  }
  return *number;
}

std::int64_t parse_id(const std::string& text) {
  return parse_number<std::int64_t>(text).value_or(-1);
}

void route_post(HttpServer& http, const std::string& pattern, const httplib::Server::Handler& handler) {
  http.Post(pattern, [handler](const httplib::Request& request, httplib::Response& response,
                               const httplib::ContentReader&) { handler(request, response); });
}

std::string read_json_body(const httplib::Request& request, const std::string& what) {
  const std::string type = request.get_header_value("Content-Type");
  if (type.substr(0, type.find(';')) != "application/json") {
    throw HttpError(415, what + " is refused", "the body must be JSON", "header Content-Type: application/json");
  }
  return Exchange::current().body().text();
}

Api::Api(const ServiceOptions& options, const DataFolder& folder, Store& store, RunEvents& events, JobQueue& queue)
    : options_(options),
      folder_(folder),
      store_(store),
      nights_(store),
      events_(events),
      queue_(queue),
      names_(options.host, options.host_names) {}

void Api::route(HttpServer& http) {
  using HandlerResponse = httplib::Server::HandlerResponse;
  http.set_payload_max_length(options_.upload_limit_bytes);
  http.set_default_headers({
      {"X-Content-Type-Options", "nosniff"},
      {"Accept-Ranges", "none"},  // the library says "bytes" to a HEAD for what choose_bytes() does not answer
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
       "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
  });
  http.set_exception_handler([](const Request&, Response& response, const std::exception_ptr& exception) {
    write_error(response, http_error_from(exception));
  });
  // Before any body is read: what is refused here costs no more than its header.
  http.set_pre_routing_handler([this](const Request& request, Response& response) {
    try {
      check_request(request);
      check_origin(request);
    } catch (const HttpError& error) {
      write_error(response, error);
      return HandlerResponse::Handled;
    }
    return HandlerResponse::Unhandled;
  });
  http.set_expect_100_continue_handler([this](const Request& request, Response& response) {
    try {
      check_request(request);
      check_origin(request);
      return 100;
    } catch (const HttpError& error) {
      write_error(response, error);
      return error.status();
    }
  });
  http.set_error_handler(httplib::Server::HandlerWithResponse([](const Request& request, Response& response) {
    if (!response.body.empty()) return HandlerResponse::Unhandled;
    const bool missing = response.status == 404;
    write_error(response,
                HttpError(response.status, missing ? "there is no such page" : "the request is refused",
                          missing ? "see docs/http_api.md for what there is" : "it is malformed", request.path));
    return HandlerResponse::Handled;
  }));

  http.Get("/api/health", [this](const Request&, Response& response) { get_health(response); });
  http.Get("/api/techniques", [](const Request&, Response& response) {
    write_json(response, 200, {{"techniques", replay::registry_json()}});
  });
  http.Get("/api/limits", [](const Request&, Response& response) {
    write_json(response, 200, {{"limits", replay::limits_json()}});
  });
  http.Get("/api/palettes", [](const Request&, Response& response) {
    write_json(response, 200, {{"palettes", replay::palettes_json()}});
  });
  route_captures(http);
  route_runs(http);
  route_nights(http);
  route_web(http);
  route_post(http, ".*", [](const Request& request, Response& response) {
    write_error(response, HttpError(404, "there is no such page", "nothing takes a POST here", request.path));
  });
}

void Api::serve(HttpServer& http) {
  const auto open_body = [this](std::uint64_t length) {
    if (folder_.free_bytes() < length + options_.reserved_bytes) {
      throw HttpError(507, "the body can't be stored", "the disk has too little room", "data folder");
    }
    return std::make_unique<Upload>(folder_);
  };
  http.serve(
      open_body, [this](std::int64_t run, std::int64_t last_seen) { return run_news(run, last_seen); },
      ": still here\n\n");
}

void Api::check_request(const Request& request) const {
  if (!is_reading(request) && request.method != "POST" && request.method != "DELETE") {
    throw HttpError(405, "the request is refused", "the method is not one of GET, HEAD, POST, DELETE", request.method);
  }
  if (request.has_header("Transfer-Encoding")) {
    throw HttpError(411, "the request is refused", "the length of a body must be known beforehand",
                    "header Transfer-Encoding");
  }
  if (request.has_header("Content-Encoding")) {
    throw HttpError(415, "the request is refused", "compressed bodies are not taken", "header Content-Encoding");
  }
  const std::size_t lengths = request.get_header_value_count("Content-Length");
  if (lengths > 1) throw HttpError(400, "the request is malformed", "it has several lengths", "header Content-Length");
  const std::uint64_t length = content_length(request);
  const bool upload = request.method == "POST" && request.path == "/api/captures";
  const std::uint64_t limit = upload ? options_.upload_limit_bytes : request.method == "POST" ? kMaxOtherBodyBytes : 0;
  if (length > limit) {
    throw HttpError(413, "the body is too large", fmt::format("it has {} bytes, at most {} are taken", length, limit),
                    "header Content-Length");
  }
}

// Any page in the user's browser can send requests to this machine. Two things keep it out: a state-changing request
// must come from our own pages or from no page at all, and the Host must not be a name that someone else can point at
// this machine (DNS rebinding), for then their pages would count as our own.
void Api::check_origin(const Request& request) const {
  const std::string host = request.get_header_value("Host");
  if (request.get_header_value_count("Host") != 1 || !names_.is_own_host(host)) {
    throw HttpError(421, "the request is refused",
                    "the Host is not an IP address, localhost or a name this service was told it has", "header Host");
  }
  if (is_reading(request)) return;
  if (request.has_header("Origin") && !names_.is_own_origin(request.get_header_value("Origin"), host)) {
    throw HttpError(403, "the request is refused", "it comes from another site's page", "header Origin");
  }
  const std::string site = request.get_header_value("Sec-Fetch-Site");
  if (!site.empty() && site != "same-origin" && site != "none") {
    throw HttpError(403, "the request is refused", "it comes from another site's page", "header Sec-Fetch-Site");
  }
}

void Api::get_health(Response& response) const {
  const StoreCounts counts = store_.counts();
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200,
             {{"status", "ok"},
              {"version", SUBPIXEL_VERSION},
              {"captures", counts.captures},
              {"runs", counts.runs},
              {"queued", counts.queued},
              {"running", counts.running},
              {"upload_limit_bytes", options_.upload_limit_bytes},
              {"free_bytes", folder_.free_bytes()}});
}

void Api::route_web(HttpServer& http) {
  const auto send = [](const EmbeddedFile& file, const Request& request, Response& response) {
    response.set_header("ETag", std::string(file.etag));
    response.set_header("Cache-Control", "no-cache");  // asks each time; the tag makes that cheap
    if (request.get_header_value("If-None-Match") == file.etag) {
      response.status = 304;
    } else {
      response.set_content(file.content.data(), file.content.size(), std::string(file.media_type));
    }
  };
  http.Get(R"(/([a-z0-9_/.-]*))", [send](const Request& request, Response& response) {
    const std::string path = request.path == "/" ? "index.html" : request.path.substr(1);
    for (const EmbeddedFile& file : web::files()) {
      if (file.path == path) return send(file, request, response);
    }
    throw HttpError(404, "there is no such page", "see docs/http_api.md for what there is", request.path);
  });
}

}  // namespace subpixel::server
