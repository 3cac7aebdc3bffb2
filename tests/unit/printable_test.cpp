#include "base/printable.hpp"

#include <gtest/gtest.h>

#include "base/json_text.hpp"

namespace subpixel {
namespace {

TEST(Printable, LeavesWhatCanBeSeen) {
  for (const char* const text :
       {"", "plain", "a b.spcap", "gr\xc3\xbc\xc3\x9f", "\xe2\x82\xac 5", "\xf0\x9f\x8c\xb3", "C:\\x"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, EscapesControlsInEveryEncoding) {
  EXPECT_EQ(printable("a\tb\nc\r\x7f"), "a\\x09b\\x0ac\\x0d\\x7f");
  EXPECT_EQ(printable("\x1b[2J\x1b]0;title\x07"), "\\x1b[2J\\x1b]0;title\\x07");
  EXPECT_EQ(printable(std::string_view("\0x", 2)), "\\x00x");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u{9b}31m")
      << "the one-character form of ESC [";
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m")
      << "and its byte in Latin-1";
}

TEST(Printable, EscapesWhatTurnsTextAroundOrHasNoWidth) {
  EXPECT_EQ(printable("\xe2\x80\xaegnp.exe"), "\\u{202e}gnp.exe");
  EXPECT_EQ(printable("a\xe2\x80\x8b"
                      "b\xef\xbb\xbf"),
            "a\\u{200b}b\\u{feff}");
  EXPECT_EQ(printable("\xe2\x81\xa6\xe2\x80\xa8\xd8\x9c"), "\\u{2066}\\u{2028}\\u{61c}");
  EXPECT_EQ(printable("\xf3\xa0\x81\x81"), "\\u{e0041}") << "tags, which no font shows";
}

TEST(Printable, EscapesEveryByteThatIsNoUtf8) {
  EXPECT_EQ(printable("\xc3"), "\\xc3") << "cut";
  EXPECT_EQ(printable("a\xe2\x82"), "a\\xe2\\x82") << "cut";
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(printable("\xe0\x80\x9b"), "\\xe0\\x80\\x9b") << "overlong";
  EXPECT_EQ(printable("\xf0\x80\x80\x9b"), "\\xf0\\x80\\x80\\x9b") << "overlong";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xf4\x90\x80\x80\xff"), "\\xf4\\x90\\x80\\x80\\xff") << "above U+10FFFF";
}

TEST(Printable, IsCutBetweenCharacters) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdefgh", 6), "abc\xe2\x80\xa6");
  EXPECT_EQ(printable("\xc3\xbc\xc3\xbc\xc3\xbc", 5), "\xc3\xbc\xe2\x80\xa6");
  EXPECT_EQ(printable("ab\x1b", 5), "ab\xe2\x80\xa6") << "no escape is cut";
  EXPECT_EQ(printable("ab", 1), "");
  EXPECT_EQ(printable("", 0), "");
}

TEST(Printable, ChangesNothingASecondTime) {
  const std::string once = printable("a\x1b\xff\xe2\x80\xae");
  EXPECT_EQ(printable(once), once);
}

TEST(JoinedLines, AreOneLine) {
  EXPECT_EQ(joined_lines("  one\r\n\ttwo  three\n\n"), "one two three");
  EXPECT_EQ(joined_lines("\n \t"), "");
}

TEST(JsonText, IsAsciiWhateverItHolds) {
  const nlohmann::json document = {{"title", "\x1b[2J\x7f\xc2\x9b\xe2\x80\xae\xc3\xbc"}, {"name", "a\xff"}};
  const std::string text = json_text(document);
  for (const char c : text) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << text;
  EXPECT_EQ(nlohmann::json::parse(text)["title"], document["title"]);
  EXPECT_EQ(nlohmann::json::parse(text)["name"], "a\xef\xbf\xbd");
}

}  // namespace
}  // namespace subpixel
