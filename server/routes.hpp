// The table of what the service answers. The router, the rights, the metrics and the description (OpenAPI) all come
// from it, so that they can't differ.
#pragma once

#include <httplib.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <string>
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

class Routes {
 public:
  // The handler finds the path's parts in `request.matches`, in their order.
  void add(Route route, httplib::Server::Handler handler);
  // Nothing for a path that is not in the table.
  const Route* find(const std::string& method, const std::string& path) const;
  void route_into(httplib::Server& http) const;
  const std::vector<Route>& all() const { return routes_; }
  // OpenAPI 3.1.
  nlohmann::json description(const std::string& version) const;

 private:
  std::vector<Route> routes_;
  std::vector<httplib::Server::Handler> handlers_;
  std::vector<std::regex> patterns_;
};

}  // namespace subpixel::server
