// "1280x720" on a command line.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>

#include "capture_format/error.hpp"

namespace subpixel::cli {

struct FrameSize {
  std::uint32_t width, height;  // pixels
};

// Whether the sides are in range is for who uses them. Throws UsageError when it is no WIDTHxHEIGHT.
inline FrameSize parse_frame_size(const std::string& text) {
  const char* const end = text.data() + text.size();
  FrameSize size{};
  auto [after_width, error] = std::from_chars(text.data(), end, size.width);
  if (error == std::errc() && after_width != end && *after_width == 'x') {
    const auto height = std::from_chars(after_width + 1, end, size.height);
    if (height.ec == std::errc() && height.ptr == end) return size;
  }
  throw UsageError("wrong size", "expected WIDTHxHEIGHT in pixels, got " + text, "--size");
}

}  // namespace subpixel::cli
