// Names in other people's files are of any encoding; a capture holds UTF-8.
#pragma once

#include <string>
#include <string_view>

#include "capture_format/checks.hpp"
#include "capture_format/limits.hpp"

namespace subpixel::capture {

// `text` itself when it is UTF-8 and short enough, else read as Latin-1, cut to 256 characters.
inline std::string to_utf8(std::string_view text) {
  if (is_utf8(text) && text.size() <= kMaxTextBytes) return std::string(text);
  std::string converted;
  for (const char c : text.substr(0, 256)) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      converted += c;
    } else {
      converted += static_cast<char>(0xc0 | (code >> 6));
      converted += static_cast<char>(0x80 | (code & 0x3f));
    }
  }
  return converted;
}

}  // namespace subpixel::capture
