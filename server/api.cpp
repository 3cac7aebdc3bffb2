// What all routes share: limits, the defence against other sites, headers, health, the viewer's files.
#include "server/api.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>

#include "base/log_fields.hpp"
#include "base/numbers.hpp"
#include "replay/measure/maps.hpp"
#include "replay/results/limits.hpp"
#include "replay/techniques/registry.hpp"
#include "server/http_error.hpp"
#include "server/request_context.hpp"
#include "server/upload.hpp"
#include "web/embedded.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

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

// Of the viewer.
void send_web_file(const httplib::Request& request, httplib::Response& response) {
  const std::string path =
      request.path == "/" ? "index.html" : request.path.substr(std::min<std::size_t>(1, request.path.size()));
  const auto& files = web::files();
  const auto file = std::ranges::find_if(files, [&](const EmbeddedFile& one) { return one.path == path; });
  if (file == files.end())
    throw HttpError(404, "there is no such page", "see docs/http_api.md for what there is", request.path);
  response.set_header("ETag", std::string(file->etag));
  response.set_header("Cache-Control", "no-cache");  // asks each time; the tag makes that cheap
  if (request.get_header_value("If-None-Match") == file->etag) {
    response.status = 304;
  } else {
    response.set_content(file->content.data(), file->content.size(), std::string(file->media_type));
  }
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
      names_(options.host, options.host_names),
      access_(options.require_token, store) {}

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
  // Before any body is read: what is refused here costs no more than its header. All is answered from here: the
  // library's own router tries a regular expression for each operation, and reads bodies into memory.
  http.set_pre_routing_handler([this](const Request& request, Response& response) {
    response.set_header("X-Request-Id", Exchange::current().id());
    try {
      admit(request);
      dispatch(request, response);
    } catch (...) {
      write_error(response, http_error_from(std::current_exception()));
    }
    return HandlerResponse::Handled;
  });
  http.set_expect_100_continue_handler([this](const Request& request, Response& response) {
    try {
      admit(request);
      return 100;
    } catch (...) {
      write_error(response, http_error_from(std::current_exception()));
      return response.status;
    }
  });
  http.set_logger([this](const Request& request, const Response& response) { answered(request, response); });
  http.set_error_handler(httplib::Server::HandlerWithResponse([](const Request& request, Response& response) {
    const bool missing = response.status == 404;
    if (response.body.empty()) {
      write_error(response,
                  HttpError(response.status, missing ? "there is no such page" : "the request is refused",
                            missing ? "see docs/http_api.md for what there is" : "it is malformed", request.path));
    }
    return HandlerResponse::Handled;  // or the library leaves the length out where it asks before the body
  }));

  route_state(routes_);
  route_access(routes_);
  const auto table = [this](const char* what, const char* meaning, const char* schema, json (*make)()) {
    routes_.add({.method = "GET",
                 .path = std::string("/api/") + what,
                 .id = std::string("get_") + what,
                 .meaning = meaning,
                 .answers = {{200, schema}}},
                [what, make](const Request&, Response& response) {
                  write_json(response, 200, {{what, make()}});
                });
  };
  table("techniques", "The registry of techniques", "Techniques", &replay::registry_json);
  table("limits", "What a run can be asked for", "Limits", &replay::limits_json);
  table("palettes", "The colours of maps, evenly spaced points of them", "Palettes", &replay::palettes_json);
  route_captures(routes_);
  route_runs(routes_);
  route_nights(routes_);
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

// Of the table; what is not in it and is none of the viewer's files is read or changed by those who may do all of that.
void Api::admit(const Request& request) {
  RequestContext& context = request_context();
  context = {
      .begun = std::chrono::steady_clock::now(), .found = routes_.find(request.method, request.path), .caller = {}};
  check_request(request);
  check_origin(request);
  Right needed = is_reading(request) ? Right::read : Right::admin;
  if (context.found.route != nullptr) {
    needed = context.found.route->right;
  } else if (is_reading(request) && !request.path.starts_with("/api/")) {
    needed = Right::none;
  }
  context.caller = access_.admit(request, needed);
}

void Api::answered(const Request& request, const Response& response) {
  const RequestContext context = take_request_context();
  const Exchange& exchange = Exchange::current();
  if (exchange.waits_for_body()) return;  // it will be answered again
  const std::string operation = context.found.route != nullptr ? context.found.route->id : "other";
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> time = now - context.begun.value_or(now);
  metrics_.count(operation, response.status, time.count(), exchange.body_bytes());
  if (!options_.log_requests) return;
  const LogField method("method", request.method), path("path", request.path), what("operation", operation);
  const LogField status("status", std::to_string(response.status)),
      ms("ms", fmt::format("{:.1f}", 1000 * time.count()));
  const LogField caller("caller", context.caller ? context.caller->name : "");
  std::optional<LogField> run;
  if (context.run) run.emplace("run", std::to_string(*context.run));
  spdlog::info("answered {} {} with {}", request.method, request.path, response.status);
}

void Api::dispatch(const Request& request, Response& response) const {
  if (const Routes::Handler* handler = request_context().found.handler) return (*handler)(request, response);
  if (is_reading(request)) return send_web_file(request, response);
  throw HttpError(404, "there is no such page", "nothing takes a " + request.method + " here", request.path);
}

}  // namespace subpixel::server
