// Tells others how a night ended: webhooks, signed and retried, and mail by the system's sendmail. Only addresses of
// the night's configuration are spoken to; redirects are not followed.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "server/nightly/config.hpp"
#include "server/nightly/night.hpp"

namespace subpixel::server {

struct Notice {
  std::string event;  // "night.ended", or "night.broken" with `night` as far as it is known
  std::string headline, text;
  NightRecord night;
  std::string address;  // of the service that shows it; may be empty
};

// What came of one delivery, in words for a log: "https://example.net/hook: 200", "...: gave up after 5 attempts: ...".
struct Delivery {
  bool arrived = false;
  std::string text;
};

// Sends to everybody who wants to know of it. `first_wait` doubles with each attempt of a webhook, up to a minute.
// Never throws for what others do.
std::vector<Delivery> send_notices(const NoticeOptions& options, const Notice& notice,
                                   std::chrono::milliseconds first_wait = std::chrono::seconds(1));

// Lower-case hexadecimal HMAC-SHA-256 (RFC 2104) of `text`.
std::string hmac_sha256(const std::string& key, const std::string& text);

}  // namespace subpixel::server
