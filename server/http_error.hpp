// Errors as HTTP says them: {"error":{"status","what","why","where"}}.
#pragma once

#include <httplib.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace subpixel::server {

// An answer other than success. `where` names the field, header or path concerned.
class HttpError : public std::runtime_error {
 public:
  HttpError(int status, std::string what, std::string why, std::string where)
      : std::runtime_error(what + ": " + why + ": " + where),
        status_(status),
        what_(std::move(what)),
        why_(std::move(why)),
        where_(std::move(where)) {}
  int status() const { return status_; }
  nlohmann::json json() const;

 private:
  int status_;
  std::string what_, why_, where_;
};

// What to answer for an exception that left a handler: UsageError and InputError are the request's fault (400), a full
// disk is 507, everything else is ours: 500, which asks for a report.
HttpError http_error_from(const std::exception_ptr& exception);

void write_error(httplib::Response& response, const HttpError& error);
void write_json(httplib::Response& response, int status, const nlohmann::json& document);

}  // namespace subpixel::server
