#include "tests/service/disk_calls.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace subpixel::tests {

std::function<int(const std::string& call, const std::string& path)> on_disk_call;

namespace {

std::string path_of(int descriptor) {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), none).string();
}

int called(const std::string& call, const std::string& path) {
  const int error = on_disk_call ? on_disk_call(call, path) : 0;
  if (error != 0) errno = error;
  return error == 0 ? 0 : -1;
}

}  // namespace
}  // namespace subpixel::tests

using subpixel::tests::called;
using subpixel::tests::path_of;

// In place of the C library's, for SQLite too.
extern "C" int fsync(int descriptor) {
  return called("sync", path_of(descriptor)) != 0 ? -1 : static_cast<int>(::syscall(SYS_fsync, descriptor));
}
extern "C" int fdatasync(int descriptor) {
  return called("sync", path_of(descriptor)) != 0 ? -1 : static_cast<int>(::syscall(SYS_fdatasync, descriptor));
}
extern "C" int link(const char* from, const char* to) noexcept {
  return called("link", to) != 0 ? -1 : static_cast<int>(::syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0));
}
extern "C" int rename(const char* from, const char* to) noexcept {
  return called("rename", to) != 0 ? -1 : static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
