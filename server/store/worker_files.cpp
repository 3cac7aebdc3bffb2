#include "server/store/worker_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxImages = 64;
constexpr off_t kMaxImageBytes = off_t{1} << 29;  // SQLite holds blobs up to 1e9 bytes

std::string media_type_of(std::string_view file_name) {
  if (file_name.ends_with(".png")) return "image/png";
  if (file_name.ends_with(".exr")) return "image/x-exr";
  if (file_name.ends_with(".json")) return "application/json";
  return "application/octet-stream";
}

// The bytes of a plain file named by the worker, which must not lead out of its folder.
std::string read_worker_file(const std::filesystem::path& folder, const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name.front() == '.' ||
      name.find('\0') != std::string::npos) {
    throw InputError("worker result", "an image's name is not a plain file name", printable(name, 80));
  }
  const std::filesystem::path path = folder / name;
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) throw InputError("worker result", "an image it names can't be opened", printable(name, 80));
  struct Close {
    int fd;
    ~Close() { ::close(fd); }
  } const close_at_end{file};
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size > kMaxImageBytes) {
    throw InputError("worker result", "an image is no file or too large", printable(name, 80));
  }
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(file, bytes.data() + filled, bytes.size() - filled);
    if (got <= 0) throw InputError("worker result", "an image can't be read", printable(name, 80));
    filled += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace

std::map<std::string, Blob> read_worker_images(const std::filesystem::path& folder, const replay::FrameResult& result) {
  if (result.images.size() > kMaxImages) {
    throw InputError("worker result", "it names too many images", std::to_string(result.images.size()));
  }
  std::map<std::string, Blob> images;
  for (const auto& [role, file] : result.images) {
    images[role] = Blob{media_type_of(file), read_worker_file(folder, file)};
  }
  return images;
}

}  // namespace subpixel::server
