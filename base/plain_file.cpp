#include "base/plain_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.hpp"

namespace subpixel {

std::string read_plain_file(const std::filesystem::path& path, std::uint64_t most_bytes, const std::string& what,
                            const std::string& shown) {
  // Without O_NONBLOCK a pipe of that name would be waited for.
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw InputError(what, "it can't be opened", shown);
  struct Close {
    int fd;
    ~Close() { ::close(fd); }
  } const close_at_end{file};
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode) ||
      static_cast<std::uint64_t>(status.st_size) > most_bytes) {
    throw InputError(what, "it is no file or too large", shown);
  }
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = ::read(file, bytes.data() + filled, bytes.size() - filled);
    if (got <= 0) throw InputError(what, "it can't be read", shown);
    filled += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace subpixel
