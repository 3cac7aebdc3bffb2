// Looks a whole capture over: every rule of checks.hpp, and what is legal but seldom meant.
#pragma once

#include <string>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct Problem {
  enum class Severity {
    error,  // a rule is broken, or nothing sensible can come out
    note    // replay copes with it: NaN positions, draws without triangles, uvs that are absent or unused, ...
  } severity;
  std::string where;  // "frame 2, draw 17 (name), field position"
  std::string why;
};

// All problems, in the capture's order; at most 1000, the last then says that there are more. Trusts nothing: it may be
// given captures that the reader would refuse.
std::vector<Problem> validate_capture(const Capture& capture);

}  // namespace subpixel::capture
