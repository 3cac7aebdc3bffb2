#include "base/numbers.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace subpixel {
namespace {

TEST(Numbers, AreTheWholeText) {
  EXPECT_EQ(parse_number<std::uint32_t>("4294967295"), 4294967295u);
  EXPECT_EQ(parse_number<std::int64_t>("-7"), -7);
  EXPECT_EQ(parse_number<double>("2.5e3"), 2500.0);
  for (const char* text : {"", " 7", "7 ", "+7", "7x", "0x7", "-7", "4294967296"}) {
    EXPECT_EQ(parse_number<std::uint32_t>(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace subpixel
