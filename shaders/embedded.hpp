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

// Every shader of this program.
std::span<const Embedded> all();

// What all() is made of, generated: the shaders replays use, and those of shaders/tests and shaders/bench, which only
// programs that link subpixel_test_shaders have.
std::span<const Embedded> replay_shaders();
[[gnu::weak]] std::span<const Embedded> test_shaders();

}  // namespace subpixel::shaders
