// The table of what the service answers. The router, the rights, the metrics and the description (OpenAPI) all come
// from it, so that they can't differ.
#pragma once

#include <httplib.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/tokens.hpp"

namespace subpixel::server {

// A member of the query. `schema` is JSON Schema in JSON.
struct QueryMember {
  std::string name, schema, meaning;
};

// What an answer's body is: the name of a schema (server/api_schemas.json), a media type, or nothing (empty).
struct Answer {
  int status;
  std::string body;
};

struct Route {
  std::string method;   // GET (also HEAD), POST, DELETE
  std::string path;     // "/api/runs/{id}"; {hash} is 32 hexadecimal digits, every other name a number
  std::string id;       // as clients call it: "get_run"
  std::string meaning;  // one line
  Right right = Right::read;
  std::vector<Answer> answers;  // besides errors that every request can have
  std::vector<QueryMember> query = {};
  std::string body = {};  // as an answer's
};

// The values of the path's names, in their order; nothing where `path` is not of that form.
std::optional<std::vector<std::string>> path_parts(std::string_view form, std::string_view path);

class Routes {
 public:
  using Handler = httplib::Server::Handler;
  struct Found {
    const Route* route = nullptr;  // none for a path that is not in the table
    const Handler* handler = nullptr;
    std::vector<std::string> parts;
  };

  // The handler finds the path's parts by path_part() (request_context.hpp).
  void add(Route route, Handler handler);
  Found find(std::string_view method, std::string_view path) const;
  const std::vector<Route>& all() const { return routes_; }
  // OpenAPI 3.1.
  nlohmann::json description(const std::string& version) const;

 private:
  std::vector<Route> routes_;
  std::vector<Handler> handlers_;
};

}  // namespace subpixel::server
