// Under which names this service is called, and what keeps the pages of other sites out.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::server {

// "name:port", "[v6]:port" or either without a port (RFC 3986, section 3.2, without a user).
struct Authority {
  std::string host;  // lower case, without brackets and without a final dot
  std::string port;  // digits; empty when there is none
  bool operator==(const Authority&) const = default;
};

// Nothing for what is no such text.
std::optional<Authority> parse_authority(std::string_view text);

class OwnNames {
 public:
  // `listen`: the host listened on; `host_names`: further names, with a port where pages have one in their address.
  // Throws UsageError for a name that is none.
  OwnNames(const std::string& listen, const std::vector<std::string>& host_names);

  // Whether a request's Host is an IP address, localhost, the host listened on or one of the names, on any port. No one
  // can point another name at this machine then and have his pages count as ours (DNS rebinding).
  bool is_own_host(std::string_view host) const;

  // Whether an Origin is that of our own pages: scheme http or https and the request's Host, or one of the names with
  // its port, the scheme's own where it was given without one. The names are what a proxy in front is called, which
  // need not hand on the Host it was called by.
  bool is_own_origin(std::string_view origin, std::string_view host) const;

 private:
  std::string listen_;
  std::vector<Authority> names_;
};

}  // namespace subpixel::server
