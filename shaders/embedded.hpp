// The SPIR-V that the build embedded.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace subpixel::shaders {

struct Embedded {
  std::string_view name;  // "frontend/setup.comp", or "file.frag:variant"
  std::span<const std::uint32_t> words;
};

std::span<const Embedded> all();

}  // namespace subpixel::shaders
