// A request's body on its way in, a capture or not: bytes go to a file of their own and through the hash as they come,
// so memory use does not depend on their number, and nothing is left behind unless keep_capture() succeeds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/hash.hpp"
#include "server/store/data_folder.hpp"

namespace subpixel::server {

class Upload {
 public:
  // Throws HttpError 507 when the disk is full, as all functions here do.
  explicit Upload(const DataFolder& folder);
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  void append(std::string_view bytes);
  // All bytes, for a body that is known to be short.
  std::string text() const;
  // No more bytes will come: the file is on the disk (fsync). Returns the content hash.
  std::string finish();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size_bytes() const { return size_bytes_; }

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_bytes_ = 0;
  ContentHasher hasher_;
};

enum class Kept { stored, same_already, collision };
// Gives a file, whose hash that is, its place among the captures. One that is there already is compared byte by byte:
// XXH3 is no cryptographic hash, and a made-up collision must not pass for another capture. Throws as Upload does.
Kept keep_capture(const DataFolder& folder, const std::filesystem::path& file, const std::string& hash);

}  // namespace subpixel::server
