#include "scenes/import/statements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr std::string_view kBlanks = " \t\v\f";

}  // namespace

Statements::Statements(std::vector<std::byte> file, std::string where, bool continued)
    : file_(std::move(file)),
      left_(reinterpret_cast<const char*>(file_.data()), file_.size()),
      where_(std::move(where)),
      continued_(continued) {
  if (left_.starts_with("\xef\xbb\xbf")) left_.remove_prefix(3);
  // Without its mark, too: the first character is one of ASCII.
  const bool is_half_zero = left_.size() > 1 && (left_[0] == 0) != (left_[1] == 0);
  if (left_.starts_with("\xff\xfe") || left_.starts_with("\xfe\xff") || is_half_zero) {
    throw InputError("can't import the model", "its text is UTF-16; only UTF-8 and the like can be read", where_);
  }
  if (const std::size_t zero = left_.find('\0'); zero != std::string_view::npos) {
    const auto lines = std::count(left_.begin(), left_.begin() + static_cast<std::ptrdiff_t>(zero), '\n');
    throw InputError("can't import the model", "there is a byte of value 0 in it: it is no text",
                     fmt::format("{}, line {}", where_, lines + 1));
  }
}

std::string_view Statements::next_line() {
  const std::size_t end = std::min(left_.find_first_of("\r\n"), left_.size());
  const std::string_view line = left_.substr(0, end);
  left_.remove_prefix(end);
  left_.remove_prefix(left_.starts_with("\r\n") ? 2 : left_.empty() ? 0 : 1);
  ++lines_read_;
  return line;
}

std::optional<Statement> Statements::next() {
  while (!left_.empty()) {
    std::string_view text = without_blanks(next_line());
    line_ = lines_read_;
    if (text.empty() || text.front() == '#') continue;
    if (continued_ && text.back() == '\\') {
      joined_.clear();
      while (!text.empty() && text.back() == '\\') {
        joined_.append(text.substr(0, text.size() - 1)).append(" ");
        text = left_.empty() ? std::string_view() : without_blanks(next_line());
      }
      joined_.append(text);
      text = without_blanks(joined_);
      if (text.empty()) continue;
    }
    Statement statement;
    statement.keyword = lower_case(take_token(text));
    statement.rest = without_blanks(text);
    statement.line = line_;
    return statement;
  }
  return std::nullopt;
}

std::string Statements::place() const {
  return fmt::format("{}, line {}", where_, line_);
}

void Statements::fail_at(std::size_t line, const std::string& why) const {
  throw InputError("can't import the model", why, fmt::format("{}, line {}", where_, line));
}

double Statements::number(std::string_view token, const char* what) const {
  if (token.empty()) fail(fmt::format("{} is missing", what));
  const std::optional<double> value = parse_number(token);
  if (!value) fail(fmt::format("{} is {}, which is no number", what, in_quotes(token)));
  if (!std::isfinite(*value)) fail(fmt::format("{} is {}, which is not finite", what, in_quotes(token)));
  return *value;
}

std::optional<double> parse_number(std::string_view token) {
  if (token.starts_with('+')) token.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (end != token.data() + token.size() || error == std::errc::invalid_argument) return std::nullopt;
  // Too large or too small for a double, which from_chars does not tell apart.
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(token).c_str(), nullptr);
  return value;
}

std::string_view take_token(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string_view token = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(token.size());
  return token;
}

std::string_view without_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

std::string_view without_comment(std::string_view text) {
  std::size_t mark = text.find('#');
  while (mark != std::string_view::npos && mark > 0 && kBlanks.find(text[mark - 1]) == std::string_view::npos) {
    mark = text.find('#', mark + 1);
  }
  return without_blanks(text.substr(0, mark));
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kShownBytes = 60;
  return fmt::format("\"{}\"", printable(to_utf8(text), kShownBytes));
}

}  // namespace subpixel::capture
