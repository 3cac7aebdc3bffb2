// Text from outside made fit to be stored and shown.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace subpixel::server {

// `text` as valid UTF-8 without control characters, at most `limit` bytes (cut between characters, with an ellipsis).
// Every byte that is not part of a valid sequence becomes U+FFFD.
std::string printable(std::string_view text, std::size_t limit);

}  // namespace subpixel::server
