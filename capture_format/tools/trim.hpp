// A part of a capture as a capture of its own, without what only the rest needed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct TrimOptions {
  std::optional<std::pair<std::uint32_t, std::uint32_t>> frames;  // first and last that stay; all
  std::optional<std::string> keep, drop;                          // lists of draws (draw_selection.hpp), not both
};

// The frames and draws that stay, in their order, drawn with the materials, textures and bytes of buffers that they
// use; these are numbered anew. Of vertices that draws share, those from the first to the last that any of them reads
// stay. Every draw makes the same triangles of the same values as before, strips and fans as such. A notice says what
// was left out. `capture` must be one that was read, strips and fans in it as they were stored so that they don't grow.
// Throws UsageError when frames are not there, a draw is not, or nothing is left.
Capture trim(Capture capture, const TrimOptions& options);

}  // namespace subpixel::capture
