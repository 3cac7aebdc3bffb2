// Bytes as text that JSON can hold.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace subpixel {

// RFC 4648, section 4, padded.
std::string base64_text(std::span<const std::uint8_t> bytes);

}  // namespace subpixel
