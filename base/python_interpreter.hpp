// The Python that imports of RenderDoc captures run in.
#pragma once

#include <cstdlib>
#include <string>

namespace subpixel {

// The path in the environment variable SUBPIXEL_PYTHON, else the system's, which alone finds Debian's module
// `renderdoc`.
inline std::string python_interpreter() {
  const char* const named = std::getenv("SUBPIXEL_PYTHON");
  return named != nullptr ? named : "/usr/bin/python3";
}

}  // namespace subpixel
