// Bytes on their way to one client, who may read as slowly as he likes: little of them is in memory, the rest in files.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace subpixel::server {

// A descriptor that is closed with its last user.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

class Outgoing {
 public:
  // What is too much for memory goes to a file in `folder`, which outlives this; it has no name there.
  explicit Outgoing(const std::filesystem::path& folder) : folder_(&folder) {}

  void append(std::string_view bytes);
  // Text that many clients get stands in memory once.
  void append(std::shared_ptr<const std::string> text);
  void append(std::shared_ptr<const OpenFile> file, std::uint64_t first, std::uint64_t length);

  bool empty() const { return pieces_.empty(); }
  std::uint64_t sent_bytes() const { return sent_bytes_; }

  enum class Sent { all, some, failed };
  // Sends what the socket takes at once, and not too much of it, so that others get their turn.
  Sent send_to(int socket);

 private:
  // `left` bytes of a text or of a file from `first` on.
  struct Piece {
    std::shared_ptr<const std::string> text;
    std::shared_ptr<const OpenFile> file;
    std::uint64_t first = 0, left = 0;
  };
  void append_to_memory(std::string_view bytes);
  std::size_t append_to_spill(std::string_view bytes);

  const std::filesystem::path* folder_;
  std::deque<Piece> pieces_;
  std::shared_ptr<std::string> growing_;  // the last piece's text, where append() made it
  std::shared_ptr<const OpenFile> spill_;
  std::uint64_t spilled_bytes_ = 0, sent_bytes_ = 0;
  std::size_t held_bytes_ = 0;
};

}  // namespace subpixel::server
