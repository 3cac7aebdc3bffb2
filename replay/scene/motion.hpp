// How what a frame shows has moved since the frame before, for techniques that accumulate frames.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::replay {

// Where in a pixel the sample of frame `time` lies, pixels from the centre: the points 1 to `length` of Halton's
// sequence of bases 2 and 3 (1960), in turns; a length of 1 is the centre. Times before the first frame are negative.
glm::dvec2 jitter_of(std::int64_t time, std::uint32_t length);

struct FrameMotion {
  // For each instance of the frame's draws in submission order, and then once for what does not move: what takes a
  // point of the frame's clip space, divided by w and jittered, to that of the frame before without its jitter, less
  // the matrix that takes the jitter away; all 0 where nothing moved.
  std::vector<glm::mat4> differences;
  glm::vec2 unjitter{0};         // what takes the jitter away: to be added to x and y of a divided point
  glm::vec4 distance_before{0};  // (a, b, c, d): in the frame before, a depth z is (a z + b) / (c z + d) from the eye
  std::uint32_t unmatched = 0;   // instances without a counterpart in the frame before, which count as still
};

// Draws are matched by name, those of one name in order; draws without a name by the geometry they read. The
// counterpart has to have as many indices and instances. Vertices that move within a draw are not seen.
FrameMotion frame_motion(const capture::Capture& capture, std::uint32_t frame, std::uint32_t before,
                         const glm::dvec2& jitter, const glm::dvec2& size);

}  // namespace subpixel::replay
