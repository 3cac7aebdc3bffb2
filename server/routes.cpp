#include "server/routes.hpp"

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

std::string pattern_of(const std::string& path) {
  std::string pattern;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] == '{') {
      const std::size_t close = path.find('}', i);
      pattern += path.compare(i, close - i + 1, "{hash}") == 0 ? "([0-9a-f]{32})" : "([0-9]{1,18})";
      i = close;
    } else {
      pattern += path[i] == '.' ? "\\." : std::string(1, path[i]);
    }
  }
  return pattern;
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

void Routes::add(Route route, httplib::Server::Handler handler) {
  patterns_.emplace_back(pattern_of(route.path));
  routes_.push_back(std::move(route));
  handlers_.push_back(std::move(handler));
}

const Route* Routes::find(const std::string& method, const std::string& path) const {
  const std::string wanted = method == "HEAD" ? "GET" : method;
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    if (routes_[i].method == wanted && std::regex_match(path, patterns_[i])) return &routes_[i];
  }
  return nullptr;
}

void Routes::route_into(httplib::Server& http) const {
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    const std::string pattern = pattern_of(routes_[i].path);
    if (routes_[i].method == "GET") {
      http.Get(pattern, handlers_[i]);
    } else if (routes_[i].method == "DELETE") {
      http.Delete(pattern, handlers_[i]);
    } else {
      // The library would read the body into memory otherwise; ours is in the exchange (http_exchange.hpp).
      http.Post(pattern, [handler = handlers_[i]](const httplib::Request& request, httplib::Response& response,
                                                  const httplib::ContentReader&) { handler(request, response); });
    }
  }
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
