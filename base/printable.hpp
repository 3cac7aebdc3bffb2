// Texts of others (file names, titles, messages of libraries) made fit for a terminal, a log, a table or the store.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace subpixel {

// `text` as one line of valid UTF-8 in which everything can be seen: controls (C0, DEL, C1), line separators and
// characters that have no width or turn the direction of writing, with which one name can be made to read as another,
// become \x1b (below 80 hexadecimal) or \u{202e}, bytes that are no UTF-8 \xff. At most `limit` bytes, cut between
// characters, with an ellipsis.
std::string printable(std::string_view text, std::size_t limit = std::string_view::npos);

// `text` in one line: runs of line ends, tabs and spaces become one space, none is left at its ends. For messages of
// libraries and the last words of programs, whose lines mean nothing; names go to printable() as they are.
std::string joined_lines(std::string_view text);

}  // namespace subpixel
