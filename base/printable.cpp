#include "base/printable.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>

namespace subpixel {
namespace {

struct Character {
  char32_t code;
  std::size_t bytes;
};

// The UTF-8 character at the start of `text`; nothing when it is not valid (RFC 3629, section 4: no overlong forms, no
// surrogates, nothing above U+10FFFF).
std::optional<Character> first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return Character{lead, 1};
  const std::size_t length = lead >= 0xc2 && lead <= 0xdf   ? 2
                             : (lead & 0xf0) == 0xe0        ? 3
                             : lead >= 0xf0 && lead <= 0xf4 ? 4
                                                            : 0;
  if (length == 0 || text.size() < length) return std::nullopt;
  char32_t code = lead & (0xff >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return std::nullopt;
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  if (overlong || (code >= 0xd800 && code <= 0xdfff) || code > 0x10ffff) return std::nullopt;
  return Character{code, length};
}

struct CodeRange {
  char32_t first, last;
};

// Unicode's categories Cc and Zl, Zp, and of Cf what has no width or turns the direction.
constexpr std::array kUnseen{
    CodeRange{0x00, 0x1f},     CodeRange{0x7f, 0x9f},     CodeRange{0xad, 0xad},       CodeRange{0x61c, 0x61c},
    CodeRange{0x180e, 0x180e}, CodeRange{0x200b, 0x200f}, CodeRange{0x2028, 0x202e},   CodeRange{0x2060, 0x206f},
    CodeRange{0xfeff, 0xfeff}, CodeRange{0xfff9, 0xfffb}, CodeRange{0xe0000, 0xe007f},
};

bool is_unseen(char32_t code) {
  return std::ranges::any_of(kUnseen, [code](const CodeRange& r) { return code >= r.first && code <= r.last; });
}

std::string escape(char32_t code) {
  std::array<char, 16> text{};
  const int length =
      std::snprintf(text.data(), text.size(), code < 0x80 ? "\\x%02x" : "\\u{%x}", static_cast<unsigned>(code));
  return {text.data(), static_cast<std::size_t>(length)};
}

std::string escape_byte(char byte) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "\\x%02x", static_cast<unsigned>(static_cast<std::uint8_t>(byte)));
  return text.data();
}

}  // namespace

std::string printable(std::string_view text, std::size_t limit) {
  constexpr std::string_view kEllipsis = "\xe2\x80\xa6";
  std::string out;
  std::size_t end_before_ellipsis = 0;  // where to cut when the text does not fit
  while (!text.empty()) {
    const std::optional<Character> character = first_character(text);
    const std::size_t bytes = character ? character->bytes : 1;
    std::string piece(text.substr(0, bytes));
    if (!character) {
      piece = escape_byte(text[0]);
    } else if (is_unseen(character->code)) {
      piece = escape(character->code);
    }
    text.remove_prefix(bytes);
    if (piece.size() > limit - out.size()) {
      out.resize(end_before_ellipsis);
      if (limit >= kEllipsis.size()) out += kEllipsis;
      return out;
    }
    out += piece;
    if (limit - out.size() >= kEllipsis.size()) end_before_ellipsis = out.size();
  }
  return out;
}

std::string joined_lines(std::string_view text) {
  std::string out;
  bool gap = false;
  for (const char c : text) {
    if (c == '\n' || c == '\r' || c == '\t' || c == ' ') {
      gap = true;
      continue;
    }
    if (gap && !out.empty()) out += ' ';
    gap = false;
    out += c;
  }
  return out;
}

}  // namespace subpixel
