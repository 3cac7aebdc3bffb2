// Disk calls of the test program itself, seen and made to fail.
#pragma once

#include <functional>
#include <string>

namespace subpixel::tests {

// Called at every fsync, fdatasync, link and rename of this program with what was done ("sync", "link", "rename") to
// which path, from any thread; a number other than 0 is the error it ends with.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables): the C library's functions have no other way to it
extern std::function<int(const std::string& call, const std::string& path)> on_disk_call;

}  // namespace subpixel::tests
