// Files that another process put there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace subpixel {

// The bytes of a regular file of at most `most_bytes`; a symbolic link is not followed. Throws InputError, which begins
// with `what` and ends with `shown`: it can't be opened, is no file, too large, or can't be read.
std::string read_plain_file(const std::filesystem::path& path, std::uint64_t most_bytes, const std::string& what,
                            const std::string& shown);

}  // namespace subpixel
