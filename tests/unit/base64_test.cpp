// The examples of RFC 4648, section 10.
#include "base/base64.hpp"

#include <gtest/gtest.h>

#include <string_view>
#include <utility>
#include <vector>

namespace subpixel {
namespace {

TEST(Base64, IsThatOfTheRfc) {
  constexpr std::pair<std::string_view, std::string_view> kExamples[] = {
      {"", ""},
      {"f", "Zg=="},
      {"fo", "Zm8="},
      {"foo", "Zm9v"},
      {"foob", "Zm9vYg=="},
      {"fooba", "Zm9vYmE="},
      {"foobar", "Zm9vYmFy"},
  };
  for (const auto& [bytes, text] : kExamples) {
    EXPECT_EQ(base64_text(std::vector<std::uint8_t>(bytes.begin(), bytes.end())), text);
  }
  EXPECT_EQ(base64_text(std::vector<std::uint8_t>{0xfb, 0xff, 0xfe}), "+//+");
}

}  // namespace
}  // namespace subpixel
