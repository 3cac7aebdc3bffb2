// A file's bytes in memory as they are asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace subpixel {

// The whole of a regular file, read by the system page by page at first use. The file must not become shorter
// meanwhile: whoever reads what was cut off is ended by SIGBUS. Throws InputError naming the path: no such file, no
// permission, not a regular file, more than `most_bytes`.
class MappedFile {
 public:
  MappedFile(const std::filesystem::path& path, std::uint64_t most_bytes);
  ~MappedFile();
  MappedFile(MappedFile&& from) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace subpixel
