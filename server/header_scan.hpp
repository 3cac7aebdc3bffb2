// Where a request's header ends, found while it comes. Says nothing of what is in it: that is the library's to read, so
// that no two readers can differ about it.
#pragma once

#include <cstddef>
#include <string_view>

#include "server/http_limits.hpp"

namespace subpixel::server {

class HeaderScan {
 public:
  enum class Found { nothing_yet, end, long_line, long_header };

  // Goes on in `input`, all that has come of the request. `end`: its first header_bytes() are the header.
  Found scan(std::string_view input, const HttpLimits& limits) {
    while (true) {
      const std::size_t newline = input.find('\n', position_);
      const bool whole_line = newline != std::string_view::npos;
      position_ = whole_line ? newline + 1 : input.size();
      if (position_ - line_begin_ > limits.header_line_bytes) return Found::long_line;
      if (position_ > limits.header_bytes) return Found::long_header;
      if (!whole_line) return Found::nothing_yet;
      // As the library has it: the first line is the request's, whatever it says, and a bare LF ends no header.
      const bool blank = line_begin_ > 0 && input.substr(line_begin_, position_ - line_begin_) == "\r\n";
      line_begin_ = position_;
      if (blank) return Found::end;
    }
  }

  std::size_t header_bytes() const { return position_; }

 private:
  std::size_t line_begin_ = 0, position_ = 0;
};

}  // namespace subpixel::server
