// The variants of ordered passes for devices with VK_EXT_fragment_shader_interlock, which lavapipe is not: that they
// ask for the order they need. What they do else is the source of the tested ones.
#include <gtest/gtest.h>

#include <algorithm>

#include "shaders/embedded.hpp"

namespace subpixel::replay {
namespace {

std::size_t count_of(std::span<const std::uint32_t> words, std::uint32_t opcode, std::uint32_t operand = 0) {
  constexpr std::size_t kHeaderWords = 5;
  std::size_t count = 0;
  for (std::size_t at = kHeaderWords; at < words.size();) {
    const std::uint32_t length = words[at] >> 16;
    if (length == 0) return 0;
    const bool wanted = operand == 0 || (length > 2 && words[at + 2] == operand);
    count += (words[at] & 0xffffu) == opcode && wanted ? 1 : 0;
    at += length;
  }
  return count;
}

TEST(Interlock, OrderedVariantsBeginAndEndOnce) {
  constexpr std::uint32_t kExecutionMode = 16, kPixelInterlockOrdered = 5366, kBegin = 5364, kEnd = 5365;
  for (const std::string_view name : {"techniques/streaming/compress.frag", "techniques/dcaa/merge.frag"}) {
    for (const bool interlock : {false, true}) {
      const std::string variant = std::string(name) + (interlock ? ":INTERLOCK" : ":BUFFER");
      const auto shaders = shaders::all();
      const auto found = std::ranges::find(shaders, variant, &shaders::Embedded::name);
      ASSERT_NE(found, shaders.end()) << variant;
      const std::size_t expected = interlock ? 1 : 0;
      EXPECT_EQ(count_of(found->words, kExecutionMode, kPixelInterlockOrdered), expected) << variant;
      EXPECT_EQ(count_of(found->words, kBegin), expected) << variant;
      EXPECT_EQ(count_of(found->words, kEnd), expected) << variant;
    }
  }
}

}  // namespace
}  // namespace subpixel::replay
