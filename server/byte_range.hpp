// Parts of large answers (RFC 9110, section 14), so that a broken download goes on where it ended.
#pragma once

#include <httplib.h>

#include <cstdint>
#include <optional>
#include <string>

namespace subpixel::server {

struct BytePart {
  std::uint64_t first = 0, length = 0;
};

// What of `size` bytes whose strong entity tag is `tag` (quoted) answers a GET or HEAD. Sets ETag, Accept-Ranges and,
// for a part, status 206 and Content-Range. Nothing when the answer is complete without bytes: 304 when the client has
// them, 416 when its range lies beyond them. Several ranges at once are answered with the whole, as is a range whose
// If-Range names another tag.
std::optional<BytePart> choose_bytes(const httplib::Request& request, httplib::Response& response, std::uint64_t size,
                                     const std::string& tag);

}  // namespace subpixel::server
