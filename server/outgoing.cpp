#include "server/outgoing.hpp"

#include <fcntl.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace subpixel::server {
namespace {

constexpr std::size_t kHeldBytes = 16384;  // in memory; thousands of clients that don't read must fit into it
constexpr std::uint64_t kTurnBytes = std::uint64_t{1} << 18;

std::shared_ptr<const OpenFile> open_unnamed(const std::filesystem::path& folder) {
  std::string name = (folder / "answer-XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) return nullptr;
  ::unlink(name.c_str());
  return std::make_shared<const OpenFile>(descriptor);
}

ssize_t send_text(int socket, const std::string& text, std::uint64_t first, std::size_t size, bool more) {
  return ::send(socket, text.data() + first, size, MSG_NOSIGNAL | MSG_DONTWAIT | (more ? MSG_MORE : 0));
}

// No bytes of a file that should have some are an error: it was cut meanwhile.
ssize_t send_file(int socket, int file, std::uint64_t first, std::size_t size) {
  auto offset = static_cast<off_t>(first);
  const ssize_t sent = ::sendfile(socket, file, &offset, size);
  if (sent == 0) errno = EIO;
  return sent == 0 ? -1 : sent;
}

}  // namespace

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Outgoing::append(std::string_view bytes) {
  if (held_bytes_ + bytes.size() > kHeldBytes || spill_) bytes.remove_prefix(append_to_spill(bytes));
  if (!bytes.empty()) append_to_memory(bytes);
}

void Outgoing::append(std::shared_ptr<const std::string> text) {
  growing_.reset();
  const std::uint64_t size = text->size();
  if (size > 0) pieces_.push_back({std::move(text), nullptr, 0, size});
}

void Outgoing::append(std::shared_ptr<const OpenFile> file, std::uint64_t first, std::uint64_t length) {
  growing_.reset();
  if (length > 0) pieces_.push_back({nullptr, std::move(file), first, length});
}

void Outgoing::append_to_memory(std::string_view bytes) {
  if (!growing_) {
    growing_ = std::make_shared<std::string>();
    pieces_.push_back({growing_, nullptr, 0, 0});
  }
  growing_->append(bytes);
  pieces_.back().left += bytes.size();
  held_bytes_ += bytes.size();
}

// How much of `bytes` went to the file. On a full disk that is less: answers must come then too, so the rest is for
// memory.
std::size_t Outgoing::append_to_spill(std::string_view bytes) {
  if (!spill_) spill_ = open_unnamed(*folder_);
  if (!spill_) return 0;
  std::size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t step = ::pwrite(spill_->descriptor(), bytes.data() + written, bytes.size() - written,
                                  static_cast<off_t>(spilled_bytes_ + written));
    if (step < 0 && errno == EINTR) continue;
    if (step <= 0) break;
    written += static_cast<std::size_t>(step);
  }
  if (!pieces_.empty() && pieces_.back().file == spill_) {
    pieces_.back().left += written;
  } else {
    append(spill_, spilled_bytes_, written);
  }
  spilled_bytes_ += written;
  return written;
}

Outgoing::Sent Outgoing::send_to(int socket) {
  const std::uint64_t turn_end = sent_bytes_ + kTurnBytes;
  while (!pieces_.empty()) {
    Piece& piece = pieces_.front();
    if (sent_bytes_ >= turn_end) return Sent::some;
    const auto size = static_cast<std::size_t>(std::min(piece.left, turn_end - sent_bytes_));
    const ssize_t sent = piece.text ? send_text(socket, *piece.text, piece.first, size, pieces_.size() > 1)
                                    : send_file(socket, piece.file->descriptor(), piece.first, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return errno == EAGAIN ? Sent::some : Sent::failed;
    sent_bytes_ += static_cast<std::uint64_t>(sent);
    piece.first += static_cast<std::uint64_t>(sent);
    piece.left -= static_cast<std::uint64_t>(sent);
    if (piece.left > 0) continue;
    if (piece.text == growing_) growing_.reset();
    if (piece.text) held_bytes_ = 0;
    pieces_.pop_front();
  }
  spill_.reset();
  spilled_bytes_ = 0;
  return Sent::all;
}

}  // namespace subpixel::server
