#include "server/own_names.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>

#include "base/error.hpp"

namespace subpixel::server {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool is_port(std::string_view text) {
  return text.size() <= 5 && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

bool is_ipv6(const std::string& host) {
  in6_addr address{};
  return ::inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool is_ip_address(const std::string& host) {
  in_addr address{};
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1 || is_ipv6(host);
}

}  // namespace

std::optional<Authority> parse_authority(std::string_view text) {
  Authority authority;
  std::string_view rest;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    authority.host = lower(text.substr(1, end - 1));
    if (!is_ipv6(authority.host)) return std::nullopt;
    rest = text.substr(end + 1);
  } else {
    const std::size_t colon = std::min(text.find(':'), text.size());
    authority.host = lower(text.substr(0, colon));
    if (authority.host.ends_with('.')) authority.host.pop_back();
    const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '_'; };
    if (authority.host.empty() || !std::ranges::all_of(authority.host, allowed)) return std::nullopt;
    rest = text.substr(colon);
  }
  if (rest.empty()) return authority;
  if (rest[0] != ':' || !is_port(rest.substr(1))) return std::nullopt;
  authority.port = rest.substr(1);
  return authority;
}

OwnNames::OwnNames(const std::string& listen, const std::vector<std::string>& host_names) : listen_(lower(listen)) {
  for (const std::string& name : host_names) {
    const std::optional<Authority> authority = parse_authority(name);
    if (!authority) throw UsageError("host name", "expected NAME or NAME:PORT, got " + name, "--host-name");
    names_.push_back(*authority);
  }
}

bool OwnNames::is_own_host(std::string_view host) const {
  const std::optional<Authority> called = parse_authority(host);
  if (!called) return false;
  return called->host == "localhost" || called->host == listen_ || is_ip_address(called->host) ||
         std::ranges::any_of(names_, [&](const Authority& name) { return name.host == called->host; });
}

bool OwnNames::is_own_origin(std::string_view origin, std::string_view host) const {
  const std::string text = lower(origin);
  const bool secure = text.starts_with("https://");
  if (!secure && !text.starts_with("http://")) return false;
  const std::optional<Authority> page = parse_authority(std::string_view(text).substr(secure ? 8 : 7));
  if (!page) return false;
  if (page == parse_authority(host)) return true;
  const std::string default_port = secure ? "443" : "80";
  const auto port_of = [&](const Authority& authority) {
    return authority.port.empty() ? default_port : authority.port;
  };
  return std::ranges::any_of(
      names_, [&](const Authority& name) { return name.host == page->host && port_of(name) == port_of(*page); });
}

}  // namespace subpixel::server
