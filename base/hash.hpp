// The content hash that names a capture everywhere: in results, caches and the store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

struct XXH3_state_s;

namespace subpixel {

// XXH3-128.
struct ContentHash {
  std::uint64_t high = 0, low = 0;
  bool operator==(const ContentHash&) const = default;
  // In canonical (big-endian) order: 32 lowercase digits.
  std::string hex() const;
};

// The hash of bytes that come piece by piece.
class ContentHasher {
 public:
  ContentHasher();
  void add(std::span<const std::byte> bytes);
  // Of all bytes up to now.
  ContentHash hash() const;

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

// The hash of the bytes as ContentHash::hex.
std::string content_hash_hex(std::span<const std::byte> bytes);

// The same of a file's bytes, read in blocks. Throws InputError when the file can't be read.
std::string content_hash_hex(const std::filesystem::path& path);

}  // namespace subpixel
