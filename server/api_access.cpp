// Signing in and out over HTTP, and who is signed in.
#include <fmt/format.h>

#include "base/json_document.hpp"
#include "server/api.hpp"
#include "server/http_error.hpp"
#include "server/request_context.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

json caller_json(bool required, const std::optional<TokenRecord>& caller) {
  json document = {{"token_required", required}, {"name", nullptr},        {"right", "admin"},
                   {"expires_utc", nullptr},     {"quota_bytes", nullptr}, {"uploaded_bytes", nullptr}};
  if (!caller) return document;
  document["name"] = caller->name;
  document["right"] = to_text(caller->right);
  if (!caller->expires_utc.empty()) document["expires_utc"] = caller->expires_utc;
  if (caller->quota_bytes) document["quota_bytes"] = *caller->quota_bytes;
  document["uploaded_bytes"] = caller->uploaded_bytes;
  return document;
}

// HttpOnly: no script sees it; Strict: no other site's page sends it. A page that came over TLS sends it over nothing
// else.
std::string cookie(const httplib::Request& request, const std::string& value, const std::string& more) {
  const bool secure = request.get_header_value("Origin").starts_with("https://");
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", kTokenCookie, value, secure ? "; Secure" : "",
                     more);
}

}  // namespace

void Api::route_access(Routes& routes) {
  routes.add({.method = "GET",
              .path = "/api/caller",
              .id = "get_caller",
              .meaning = "Who the token says is calling, and what that may",
              .answers = {{200, "Caller"}}},
             [this](const Request&, Response& response) {
               response.set_header("Cache-Control", "no-store");
               write_json(response, 200, caller_json(access_.required(), request_context().caller));
             });
  routes.add({.method = "POST",
              .path = "/api/sign-in",
              .id = "sign_in",
              .meaning = "Takes a token and answers with the cookie that stands for it",
              .right = Right::none,
              .answers = {{200, "Caller"}, {401, ""}, {429, ""}},
              .body = "SignIn"},
             [this](const Request& request, Response& response) { post_sign_in(request, response); });
  routes.add({.method = "POST",
              .path = "/api/sign-out",
              .id = "sign_out",
              .meaning = "Takes the cookie away",
              .right = Right::none,
              .answers = {{204, ""}}},
             [](const Request& request, Response& response) {
               response.set_header("Set-Cookie", cookie(request, "", "; Max-Age=0"));
               response.status = 204;
             });
}

void Api::post_sign_in(const Request& request, Response& response) {
  const json document = parse_json_document(read_json_body(request, "the token"), "token", "the body");
  const JsonField top(document, "token");
  check_names(top, {"token"}, "token", "top level");
  const std::string token = top.member("token").text();
  const TokenRecord caller = access_.sign_in(request, token);
  response.set_header("Set-Cookie", cookie(request, token, ""));
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, caller_json(access_.required(), caller));
}

}  // namespace subpixel::server
