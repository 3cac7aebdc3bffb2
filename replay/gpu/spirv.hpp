// Whether words are a SPIR-V module that a driver may be given: drivers trust what they get.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace subpixel::gpu {

// What is wrong with the framing of a module (SPIR-V 1.6, sections 2.3 and 3.42), or nothing: its header, that its
// instructions and its last function end where it does, and that it has an entry point "main" for the stage of
// `shader`, which ends its name before the variant: ".vert", ".frag" or ".comp". What the instructions say is left to
// the validation layer.
std::string fault_in_spirv(std::span<const std::uint32_t> words, std::string_view shader);

}  // namespace subpixel::gpu
