#include "replay/measure/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <system_error>

#include "capture_format/error.hpp"

namespace subpixel::replay {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw InputError("file", "cannot write: " + std::generic_category().message(error), path.string());
}

// The temporary file: removed unless it was renamed to its final name. A device or a pipe is written in place: renaming
// would put a file where it was.
class Temporary {
 public:
  explicit Temporary(const std::filesystem::path& target) : target_(target) {
    std::error_code ignored;
    const auto status = std::filesystem::status(target, ignored);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
      descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    } else {
      name_ = target.string() + ".XXXXXX";
      descriptor_ = mkostemp(name_.data(), O_CLOEXEC);
      if (descriptor_ < 0) name_.clear();
    }
    if (descriptor_ < 0) fail(target_, errno);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  void write(std::span<const std::uint8_t> bytes) const {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(target_, errno);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }

  void commit() {
    // mkostemp gives 0600; the files are for everyone the umask allows, and 0644 is what they would have been.
    if (!name_.empty() && ::fchmod(descriptor_, 0644) != 0) fail(target_, errno);
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) fail(target_, errno);  // some file systems report a full disk only here
    if (!name_.empty() && std::rename(name_.c_str(), target_.c_str()) != 0) fail(target_, errno);
    name_.clear();
  }

 private:
  std::filesystem::path target_;
  std::string name_;
  int descriptor_ = -1;
};

}  // namespace

void write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  if (path.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (error) fail(path, error.value());
  }
  Temporary temporary(path);
  temporary.write(bytes);
  temporary.commit();
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  write_file_atomically(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace subpixel::replay
