#include "server/http_error.hpp"

#include <spdlog/spdlog.h>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "server/store/sqlite.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxMessageBytes = 2000;

// The parts of "what: why: where" (base/error.hpp).
HttpError split_message(int status, std::string_view message) {
  const std::size_t first = message.find(": ");
  if (first == std::string_view::npos) return {status, std::string(message), "", ""};
  const std::string what(message.substr(0, first));
  message.remove_prefix(first + 2);
  const std::size_t last = message.rfind(": ");
  if (last == std::string_view::npos) return {status, what, std::string(message), ""};
  return {status, what, std::string(message.substr(0, last)), std::string(message.substr(last + 2))};
}

}  // namespace

nlohmann::json HttpError::json() const {
  return {{"error",
           {{"status", status_},
            {"what", printable(what_, kMaxMessageBytes)},
            {"why", printable(why_, kMaxMessageBytes)},
            {"where", printable(where_, kMaxMessageBytes)}}}};
}

HttpError http_error_from(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const HttpError& error) {
    return error;
  } catch (const Error& error) {
    return split_message(400, error.what());
  } catch (const SqliteError& error) {
    spdlog::error("store: {}", error.what());
    switch (error.cause()) {
      case SqliteError::Cause::disk_full:
        return {507, "can't store this", "the disk is full", "data folder"};
      case SqliteError::Cause::read_only:
        return {507, "can't store this", "the disk or the store can only be read", "data folder"};
      case SqliteError::Cause::busy:
        return {503, "the store is not free", "another process has held it for too long; try again", "data folder"};
      case SqliteError::Cause::damaged:
        return {500, "the store is damaged", "see subpixel store check", "data folder"};
      case SqliteError::Cause::disk:
        return {500, "the store can't be used", "the disk failed; see the service's log", "data folder"};
      case SqliteError::Cause::ours:
        break;
    }
    return {500, "internal error", "the store failed; please report it with what the service's log says", ""};
  } catch (const std::exception& error) {
    spdlog::error("request: {}", error.what());
  } catch (...) {
    spdlog::error("request: unknown exception");
  }
  return {500, "internal error", "please report it with what the service's log says", ""};
}

void write_json(httplib::Response& response, int status, const nlohmann::json& document) {
  response.status = status;
  response.set_content(document.dump(), "application/json");
}

void write_error(httplib::Response& response, const HttpError& error) {
  write_json(response, error.status(), error.json());
}

}  // namespace subpixel::server
