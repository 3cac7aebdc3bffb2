#include "replay/gpu/spirv.hpp"

#include <fmt/format.h>

#include <cstring>

namespace subpixel::gpu {
namespace {

constexpr std::size_t kHeaderWords = 5;
constexpr std::uint32_t kMagic = 0x07230203, kNewestVersion = 0x00010600;  // Vulkan 1.3 takes up to SPIR-V 1.6
constexpr std::uint32_t kOpEntryPoint = 15, kOpFunctionEnd = 56;
constexpr std::uint32_t kVertex = 0, kFragment = 4, kCompute = 5;  // execution models

std::uint32_t execution_model(std::string_view shader) {
  const std::string_view file = shader.substr(0, shader.find(':'));
  if (file.ends_with(".vert")) return kVertex;
  return file.ends_with(".frag") ? kFragment : kCompute;
}

// An instruction's literal string, up to its zero or the instruction's end.
std::string_view literal(std::span<const std::uint32_t> words) {
  const char* const text = reinterpret_cast<const char*>(words.data());
  return {text, strnlen(text, words.size_bytes())};
}

}  // namespace

std::string fault_in_spirv(std::span<const std::uint32_t> words, std::string_view shader) {
  if (words.size() < kHeaderWords) return fmt::format("{} bytes are no SPIR-V module", words.size_bytes());
  if (words[0] != kMagic) return fmt::format("it begins with {:08x}, not SPIR-V's {:08x}", words[0], kMagic);
  if (words[1] > kNewestVersion)
    return fmt::format("SPIR-V {}.{} is newer than 1.6", words[1] >> 16, words[1] >> 8 & 0xff);
  bool has_main = false;
  std::uint32_t last = 0;
  for (std::size_t at = kHeaderWords; at < words.size();) {
    const std::uint32_t length = words[at] >> 16, opcode = words[at] & 0xffff;
    if (length == 0 || length > words.size() - at)
      return fmt::format("the instruction at word {} does not end within the module", at);
    if (opcode == kOpEntryPoint && length >= 4 && words[at + 1] == execution_model(shader))
      has_main = has_main || literal(words.subspan(at + 3, length - 3)) == "main";
    last = opcode;
    at += length;
  }
  if (last != kOpFunctionEnd) return "it does not end with a function's end";
  return has_main ? "" : "it has no entry point \"main\" for its stage";
}

}  // namespace subpixel::gpu
