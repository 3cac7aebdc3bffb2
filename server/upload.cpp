#include "server/upload.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "base/atomic_file.hpp"
#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

[[noreturn]] void fail(int error) {
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) {
    throw HttpError(507, "the body can't be stored", "the disk is full", "data folder");
  }
  throw HttpError(500, "the body can't be stored", std::strerror(error), "data folder");
}

bool same_bytes(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::ifstream first(a, std::ios::binary), second(b, std::ios::binary);
  std::vector<char> first_block(std::size_t{1} << 20), second_block(first_block.size());
  while (first && second) {
    first.read(first_block.data(), static_cast<std::streamsize>(first_block.size()));
    second.read(second_block.data(), static_cast<std::streamsize>(second_block.size()));
    if (first.gcount() != second.gcount()) return false;
    if (std::memcmp(first_block.data(), second_block.data(), static_cast<std::size_t>(first.gcount())) != 0)
      return false;
  }
  return first.eof() && second.eof();
}

}  // namespace

Upload::Upload(const DataFolder& folder) {
  std::string name = (folder.uploads() / "upload-XXXXXX").string();
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail(errno);
  path_ = name;
}

Upload::~Upload() {
  if (file_ >= 0) ::close(file_);
  if (!path_.empty()) ::unlink(path_.c_str());
}

void Upload::append(std::string_view bytes) {
  hasher_.add(std::as_bytes(std::span(bytes)));
  size_bytes_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string Upload::text() const {
  std::string bytes(size_bytes_, '\0');
  const ssize_t got = ::pread(file_, bytes.data(), bytes.size(), 0);
  if (got < 0) fail(errno);
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

std::string Upload::finish() {
  // Some file systems report a full disk only here.
  if (::fsync(file_) != 0) fail(errno);
  const int closed = ::close(file_);
  file_ = -1;
  if (closed != 0) fail(errno);
  return hasher_.hash().hex();
}

Kept keep_capture(const DataFolder& folder, const std::filesystem::path& file, const std::string& hash) {
  const std::filesystem::path target = folder.capture(hash);
  // link, not rename: it fails when the name exists, so of two equal uploads at the same time one stores the file.
  if (::link(file.c_str(), target.c_str()) == 0) {
    if (const int error = sync_folder(folder.captures()); error != 0) fail(error);
    return Kept::stored;
  }
  if (errno != EEXIST) fail(errno);
  return same_bytes(file, target) ? Kept::same_already : Kept::collision;
}

}  // namespace subpixel::server
