// Lines of a text format of keywords and values, as OBJ and MTL are: line numbers for messages, comments, continued
// lines, every system's line ends. Private to the OBJ loader.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::capture {

struct Statement {
  std::string keyword;    // in lower case
  std::string_view rest;  // without blanks at either end; lives until the next call of Statements::next()
  std::size_t line = 0;   // counted from 1; of its first line where it is continued
};

class Statements {
 public:
  // `where` names the file in messages. With `continued`, a backslash at a line's end joins the next line to it, but
  // for lines of comment. Throws InputError when the file is no text of bytes (UTF-16, or with zero bytes).
  Statements(std::vector<std::byte> file, std::string where, bool continued);

  // Empty lines and lines of comment are left out.
  std::optional<Statement> next();

  // "FILE, line N" of the statement read last.
  std::string place() const;
  std::size_t line() const { return line_; }

  // Throw InputError at place(), or at another line.
  [[noreturn]] void fail(const std::string& why) const { fail_at(line_, why); }
  [[noreturn]] void fail_at(std::size_t line, const std::string& why) const;

  // A whole token as a finite number. `what` names it in the message: "x of a position".
  double number(std::string_view token, const char* what) const;

 private:
  std::string_view next_line();

  std::vector<std::byte> file_;
  std::string_view left_;
  std::string where_, joined_;
  bool continued_;
  std::size_t lines_read_ = 0, line_ = 0;
};

// A token's value where it is a number of any kind, NaN and infinity included.
std::optional<double> parse_number(std::string_view token);

// Cuts the first token, which blanks end, off `text`. Empty at the end.
std::string_view take_token(std::string_view& text);

// Blanks are spaces, tabs and what else moves the cursor in a line.
std::string_view without_blanks(std::string_view text);

// Up to a '#' that begins a word, for statements of numbers ("-1.#IND" is one); names may have one ("Material #25").
std::string_view without_comment(std::string_view text);

std::string lower_case(std::string_view text);  // of ASCII letters

// A value in a message: in quotes, cut to 60 bytes, printable.
std::string in_quotes(std::string_view text);

}  // namespace subpixel::capture
