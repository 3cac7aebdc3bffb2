// What a confined process must not be able to do, tried.
#pragma once

#include <string>

namespace subpixel::tests {

// Tries `what` (at `path` where it is about a file) and prints "done" or "refused: REASON". Returns the exit code.
int probe(const std::string& what, const std::string& path);

}  // namespace subpixel::tests
