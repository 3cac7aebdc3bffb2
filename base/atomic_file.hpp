// Files that are either complete or not there, after a crash of the machine too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace subpixel {

// A file that can't be written; `code` is the system's error number.
class WriteError : public InputError {
 public:
  WriteError(const std::filesystem::path& path, int code);
  int code() const { return code_; }

 private:
  int code_;
};

// A file in the making, beside its target under a name of its own; gone again unless commit() succeeds. A target that
// is a device or a pipe is written in place, for a rename would put a file where it was; of a symbolic link what it
// leads to is replaced. All throw InputError with the system's reason and the target's path: no folder, no permission,
// a full disk (with SIGXFSZ ignored also a file-size limit).
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  // The bytes reach the disk, then the target's name, which from here on holds them.
  void commit();

 private:
  std::filesystem::path target_;
  std::string temporary_;  // empty: written in place, or renamed already
  int descriptor_ = -1;
};

enum class MissingFolder { refuse, create };

// The whole of `bytes` as the file `path`. Throws InputError as AtomicFile does.
void write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes,
                           MissingFolder missing = MissingFolder::create);
void write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

// Makes names that were added to `folder` outlast a crash of the machine. Returns 0 or the system's error number;
// file systems that can't sync a folder count as done.
int sync_folder(const std::filesystem::path& folder);

}  // namespace subpixel
