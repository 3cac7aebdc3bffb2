// What is known of the request that this thread answers.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "server/routes.hpp"

namespace subpixel::server {

struct RequestContext {
  // Of a request that the library itself refuses, as no HTTP, nothing is known: the one before it must not stand for
  // it.
  std::optional<std::chrono::steady_clock::time_point> begun;
  Routes::Found found;                // of the table; nothing for the viewer's files and what there is not
  std::optional<TokenRecord> caller;  // none where no token is required
  std::optional<std::int64_t> run;    // that the request made, or was answered with
};

inline RequestContext& request_context() {
  thread_local RequestContext context;
  return context;
}

// What is known, which from here on is of no request.
inline RequestContext take_request_context() {
  return std::exchange(request_context(), {});
}

// The value of the path's name `index`, from 0, of the route that answers.
inline const std::string& path_part(std::size_t index) {
  return request_context().found.parts.at(index);
}

}  // namespace subpixel::server
