#include "server/store/large_blobs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "base/atomic_file.hpp"
#include "server/store/sqlite.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlockBytes = std::size_t{1} << 18;

[[noreturn]] void fail(int error, const fs::path& path) {
  using Cause = SqliteError::Cause;
  const Cause cause = error == ENOSPC || error == EDQUOT || error == EFBIG  ? Cause::disk_full
                      : error == EROFS || error == EACCES || error == EPERM ? Cause::read_only
                                                                            : Cause::disk;
  throw SqliteError(cause, std::string(std::strerror(error)) + ": " + path.string());
}

class OpenFile {
 public:
  OpenFile(const fs::path& path, int flags, mode_t mode = 0) : fd_(::open(path.c_str(), flags | O_CLOEXEC, mode)) {}
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

// The folder and its name are lasting; else it is not there, so that the next one tries again.
void make_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::create_directory(folder, error)) {
    if (error) fail(error.value(), folder);
    return;
  }
  if (const int code = sync_folder(folder.parent_path()); code != 0) {
    fs::remove(folder, error);
    fail(code, folder);
  }
}

bool is_hash(const std::string& name) {
  return name.size() == 32 &&
         std::ranges::all_of(name, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace

// All of its folders at once: whoever stores a blob later need not wonder whether a folder that is there is lasting.
void FolderBlobs::prepare() {
  make_folder(folder_);
  for (int i = 0; i < 256; ++i) {
    std::error_code error;
    fs::create_directory(folder_ / fmt::format("{:02x}", i), error);
    if (error) fail(error.value(), folder_);
  }
  for (const fs::path& folder : {folder_, folder_.parent_path()}) {
    if (const int code = sync_folder(folder); code != 0) fail(code, folder);
  }
}

void FolderBlobs::put(const std::string& hash, std::string_view bytes) {
  const fs::path path = path_of(hash);
  if (size(hash) == bytes.size()) {
    std::string_view left = bytes;
    const auto same = [&](std::string_view part) {
      if (left.substr(0, part.size()) != part) return false;
      left.remove_prefix(part.size());
      return true;
    };
    if (read(hash, 0, bytes.size(), same)) {
      // Left by who died before its row: its name may not have reached the disk.
      if (const int code = sync_folder(path.parent_path()); code != 0) fail(code, path);
      return;
    }
  }
  // Of a backup's folder, or where someone has deleted one.
  if (!fs::exists(path.parent_path())) {
    make_folder(folder_);
    make_folder(path.parent_path());
  }
  try {
    write_file_atomically(path, std::as_bytes(std::span(bytes)), MissingFolder::refuse);
  } catch (const WriteError& error) {
    fail(error.code(), path);
  }
}

bool FolderBlobs::read(const std::string& hash, std::uint64_t first, std::uint64_t length,
                       const std::function<bool(std::string_view)>& take) const {
  const OpenFile file(path_of(hash), O_RDONLY | O_NOFOLLOW);
  if (file.fd() < 0) return false;
  std::string block(std::min<std::uint64_t>(length, kBlockBytes), '\0');
  for (std::uint64_t done = 0; done < length;) {
    const std::size_t step = std::min<std::uint64_t>(block.size(), length - done);
    const ssize_t got = ::pread(file.fd(), block.data(), step, static_cast<off_t>(first + done));
    if (got < 0) fail(errno, path_of(hash));
    if (got == 0 || !take(std::string_view(block).substr(0, static_cast<std::size_t>(got)))) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

std::optional<std::uint64_t> FolderBlobs::size(const std::string& hash) const {
  struct stat status {};
  if (::lstat(path_of(hash).c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

void FolderBlobs::remove(const std::string& hash) {
  const OpenFile lock(folder_ / "lock", O_RDWR | O_CREAT, 0644);
  if (lock.fd() < 0 || ::flock(lock.fd(), LOCK_EX | LOCK_NB) != 0) return;  // garbage for later
  if (::unlink(path_of(hash).c_str()) != 0 && errno != ENOENT) fail(errno, path_of(hash));
}

void FolderBlobs::each(const std::function<void(const std::string& hash, std::uint64_t bytes)>& take) const {
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!is_hash(name) || entry->path().parent_path() != folder_ / name.substr(0, 2)) continue;
    if (const auto bytes = size(name)) take(name, *bytes);
  }
}

std::uint64_t FolderBlobs::remove_unfinished() {
  std::uint64_t removed = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::error_code gone;
    if (!name.starts_with(".subpixel-") ||
        entry->last_write_time(gone) + std::chrono::hours(1) > fs::file_time_type::clock::now())
      continue;
    if (!gone && fs::remove(entry->path(), gone)) ++removed;
  }
  return removed;
}

std::shared_ptr<void> FolderBlobs::hold() const {
  if (!fs::exists(folder_)) return std::make_shared<int>();
  auto lock = std::make_shared<OpenFile>(folder_ / "lock", O_RDWR | O_CREAT, 0644);
  if (lock->fd() < 0 || ::flock(lock->fd(), LOCK_SH) != 0) return nullptr;
  return lock;
}

std::unique_ptr<LargeBlobs> large_blobs_of(const fs::path& file) {
  return std::make_unique<FolderBlobs>(file.parent_path() / "blobs");
}

}  // namespace subpixel::server
