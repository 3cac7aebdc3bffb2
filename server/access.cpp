#include "server/access.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string_view>

#include "base/printable.hpp"
#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

// In so long an address may send so many wrong tokens. Guessing one is hopeless anyway; this bounds what trying costs.
constexpr std::uint32_t kFailures = 10;
constexpr std::chrono::seconds kFailureTime{60};
constexpr std::size_t kMaxAddresses = 10'000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Behind a proxy on this machine the client is who the proxy says: the last of its list, which it wrote itself.
std::string client_address(const httplib::Request& request) {
  const bool local = request.remote_addr.starts_with("127.") || request.remote_addr == "::1";
  const std::string forwarded = request.get_header_value("X-Forwarded-For");
  if (!local || forwarded.empty()) return request.remote_addr;
  return std::string(trimmed(std::string_view(forwarded).substr(forwarded.rfind(',') + 1))).substr(0, 64);
}

// Of the header or, without it, of the cookie; empty without both.
std::string token_of(const httplib::Request& request) {
  constexpr std::string_view kBearer = "Bearer ";
  const std::string header = request.get_header_value("Authorization");
  if (!header.empty())
    return header.starts_with(kBearer) ? std::string(trimmed(header.substr(kBearer.size()))) : header;
  const std::string cookies = request.get_header_value("Cookie");
  for (std::string_view rest = cookies; !rest.empty();) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view cookie = trimmed(rest.substr(0, end));
    const std::size_t equals = cookie.find('=');
    if (cookie.substr(0, equals) == kTokenCookie && equals != std::string_view::npos) {
      return std::string(cookie.substr(equals + 1));
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return "";
}

}  // namespace

std::optional<TokenRecord> Access::admit(const httplib::Request& request, Right needed) {
  if (!required_ || needed == Right::none) return std::nullopt;
  const std::string token = token_of(request);
  if (token.empty()) {
    throw HttpError(401, "the request is refused", "this service wants a token", "header Authorization: Bearer TOKEN");
  }
  TokenRecord record = look_up(request, token);
  if (record.right < needed) {
    throw HttpError(
        403, "the request is refused",
        fmt::format("the token may {}, and this is for those who may {}", to_text(record.right), to_text(needed)),
        "header Authorization");
  }
  return record;
}

TokenRecord Access::sign_in(const httplib::Request& request, const std::string& token) {
  return look_up(request, token);
}

TokenRecord Access::look_up(const httplib::Request& request, const std::string& token) {
  const std::string address = client_address(request);
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(mutex_);  // also while it is looked up: guesses come one after the other
  const auto known = failures_.find(address);
  if (known != failures_.end() && now - known->second.since > kFailureTime) failures_.erase(known);
  if (const auto found = failures_.find(address); found != failures_.end() && found->second.count >= kFailures) {
    throw HttpError(429, "the request is refused",
                    fmt::format("too many wrong tokens came from this address; wait {} s", kFailureTime.count()),
                    "header Authorization");
  }
  std::optional<TokenRecord> record = tokens_.find(token);
  if (record) return *std::move(record);
  if (failures_.size() >= kMaxAddresses) failures_.clear();
  Failures& failures = failures_.try_emplace(address, Failures{0, now}).first->second;
  if (++failures.count == kFailures) spdlog::warn("too many wrong tokens from {}", printable(address, 64));
  throw HttpError(401, "the request is refused", "the token is not known, has expired or was revoked",
                  "header Authorization");
}

}  // namespace subpixel::server
