#include "server/routes.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "server/api_schemas.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

// The path's parts in braces, by their names.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (std::size_t open = 0; (open = path.find('{', open)) != std::string::npos; ++open) {
    parts.push_back(path.substr(open + 1, path.find('}', open) - open - 1));
  }
  return parts;
}

bool is_hash(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// At most 18 digits, so that it fits into 64 bits.
bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= 18 && text.find_first_not_of("0123456789") == std::string_view::npos;
}

json content_of(const std::string& body) {
  if (body.find('/') != std::string::npos) {
    const bool text = body.starts_with("text/") || body.ends_with("+xml") || body.ends_with("/xml");
    return {{body, {{"schema", text ? json{{"type", "string"}} : json::object()}}}};
  }
  return {{"application/json", {{"schema", {{"$ref", "#/components/schemas/" + body}}}}}};
}

json operation_of(const Route& route) {
  json parameters = json::array();
  for (const std::string& part : parts_of(route.path)) {
    json schema = {{"type", "integer"}, {"minimum", 1}};
    if (part == "hash") schema = {{"type", "string"}, {"pattern", "^[0-9a-f]{32}$"}};
    parameters.push_back({{"name", part}, {"in", "path"}, {"required", true}, {"schema", schema}});
  }
  for (const QueryMember& member : route.query) {
    parameters.push_back({{"name", member.name},
                          {"in", "query"},
                          {"description", member.meaning},
                          {"schema", json::parse(member.schema)}});
  }
  json responses = json::object();
  for (const Answer& answer : route.answers) {
    json& response = responses[std::to_string(answer.status)];
    response["description"] = answer.status < 400 ? "success" : "an error";
    const std::string body = answer.status >= 400 && answer.body.empty() ? "Error" : answer.body;
    if (!body.empty()) response["content"] = content_of(body);
  }
  responses["default"] = {{"description", "an error"}, {"content", content_of("Error")}};
  json operation = {{"operationId", route.id},
                    {"summary", route.meaning},
                    {"x-right", to_text(route.right)},
                    {"parameters", parameters},
                    {"responses", responses}};
  if (route.right == Right::none) operation["security"] = json::array();
  if (!route.body.empty()) operation["requestBody"] = {{"required", true}, {"content", content_of(route.body)}};
  return operation;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::optional<std::vector<std::string>> path_parts(std::string_view form, std::string_view path) {
  std::vector<std::string> parts;
  while (!form.empty()) {
    const std::size_t open = std::min(form.find('{'), form.size());
    if (path.substr(0, open) != form.substr(0, open)) return std::nullopt;
    path.remove_prefix(open);
    form.remove_prefix(open);
    if (form.empty()) break;
    const std::string_view part = path.substr(0, path.find_first_of("/."));
    const bool hash = form.starts_with("{hash}");
    if (!(hash ? is_hash(part) : is_number(part))) return std::nullopt;
    parts.emplace_back(part);
    path.remove_prefix(part.size());
    form.remove_prefix(form.find('}') + 1);
  }
  if (!path.empty()) return std::nullopt;
  return parts;
}

void Routes::add(Route route, Handler handler) {
  routes_.push_back(std::move(route));
  handlers_.push_back(std::move(handler));
}

Routes::Found Routes::find(std::string_view method, std::string_view path) const {
  const std::string_view wanted = method == "HEAD" ? "GET" : method;
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    if (routes_[i].method != wanted) continue;
    if (auto parts = path_parts(routes_[i].path, path)) return {&routes_[i], &handlers_[i], std::move(*parts)};
  }
  return {};
}

json Routes::description(const std::string& version) const {
  json paths = json::object();
  for (const Route& route : routes_) paths[route.path][lower_case(route.method)] = operation_of(route);
  return {{"openapi", "3.1.0"},
          {"info",
           {{"title", "Subpixel"},
            {"version", version},
            {"description", "Captures, runs and nights of a service. See docs/http_api.md."}}},
          {"security", {{{"bearer", json::array()}}, {{"cookie", json::array()}}}},
          {"paths", paths},
          {"components",
           {{"schemas", json::parse(api_schemas()[0].content)},
            {"securitySchemes",
             {{"bearer", {{"type", "http"}, {"scheme", "bearer"}}},
              {"cookie", {{"type", "apiKey"}, {"in", "cookie"}, {"name", "subpixel_token"}}}}}}}};
}

}  // namespace subpixel::server
