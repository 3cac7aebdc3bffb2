#include "base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <random>
#include <system_error>
#include <utility>

namespace subpixel {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw WriteError(path, error);
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

WriteError::WriteError(const std::filesystem::path& path, int code)
    : InputError("can't write the file", std::generic_category().message(code), path.string()), code_(code) {}

AtomicFile::AtomicFile(const std::filesystem::path& target) : target_(target) {
  std::error_code ignored;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(target, ignored))) {
    std::filesystem::path led_to = std::filesystem::canonical(target, ignored);
    if (!ignored) target_ = std::move(led_to);
  }
  const auto status = std::filesystem::status(target, ignored);
  if (std::filesystem::is_directory(status)) fail(target, EISDIR);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    // A short name: the target's may be as long as the file system allows already.
    temporary_ = (folder_of(target_) / (".subpixel-" + std::to_string(std::random_device{}()) + ".tmp")).string();
    // O_EXCL: two writers of one file must never share a temporary. The mode is what the umask leaves of it.
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) temporary_.clear();
  }
  if (descriptor_ < 0) fail(target, errno);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(target_, written < 0 ? errno : ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  if (!temporary_.empty() && ::fsync(descriptor_) != 0) fail(target_, errno);
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) fail(target_, errno);  // some file systems report a full disk only here
  if (temporary_.empty()) return;
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(target_, errno);
  temporary_.clear();
  if (const int error = sync_folder(folder_of(target_)); error != 0) fail(target_, error);
}

void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes, MissingFolder missing) {
  if (missing == MissingFolder::create && path.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    if (error) fail(path, error.value());
  }
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  write_file_atomically(path, std::as_bytes(bytes));
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  write_file_atomically(path, std::as_bytes(std::span(text)));
}

int sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A folder that may be written to but not read can't be opened for this.
  if (descriptor < 0) return errno == EACCES ? 0 : errno;
  const int error = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return error == EINVAL || error == ENOTSUP ? 0 : error;
}

}  // namespace subpixel
