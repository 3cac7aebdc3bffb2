#include "base/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace subpixel {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& why) {
  throw InputError("the file can't be read", why, path.string());
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path, std::uint64_t most_bytes) {
  // O_NONBLOCK: a pipe of that name is refused below, not waited for.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail(path, std::generic_category().message(errno));
  struct stat status {};
  const int error = ::fstat(descriptor, &status) == 0 ? 0 : errno;
  void* mapped = nullptr;
  std::string why;
  if (error != 0) {
    why = std::generic_category().message(error);
  } else if (!S_ISREG(status.st_mode)) {
    why = "not a regular file";
  } else if (static_cast<std::uint64_t>(status.st_size) > most_bytes) {
    why = "larger than " + std::to_string(most_bytes) + " bytes";
  } else if (status.st_size > 0) {
    mapped = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (mapped == MAP_FAILED) why = std::generic_category().message(errno);
  }
  ::close(descriptor);
  if (!why.empty()) fail(path, why);
  bytes_ = {static_cast<const std::byte*>(mapped), static_cast<std::size_t>(status.st_size)};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

MappedFile::MappedFile(MappedFile&& from) noexcept : bytes_(std::exchange(from.bytes_, {})) {}

}  // namespace subpixel
