// JSON as it is printed: documents hold names and titles of others.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace subpixel {

// `document` in ASCII, so that no control character reaches a terminal; bytes that are no UTF-8 become U+FFFD.
// `indent` spaces a level, -1 for one line.
inline std::string json_text(const nlohmann::json& document, int indent = -1) {
  return document.dump(indent, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace subpixel
