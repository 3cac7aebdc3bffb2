// The content hash that names a capture everywhere: in results, caches and the store.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace subpixel {

// XXH3-128 of the bytes, canonical (big-endian) order, 32 lowercase hex digits.
std::string content_hash_hex(std::span<const std::byte> bytes);

// The same of a file's bytes, read in blocks. Throws InputError when the file can't be read.
std::string content_hash_hex(const std::filesystem::path& path);

}  // namespace subpixel
