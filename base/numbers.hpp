// Numbers that others wrote.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace subpixel {

// The number that the whole of `text` writes, as std::from_chars reads it: decimal, no blanks and no plus before it.
// Nothing for any other text, an empty one too, and for what does not fit.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace subpixel
