// Files that are either complete or not there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace subpixel::replay {

// Writes beside `path` and renames over it, creating the folder when missing. Throws InputError with the system's
// reason (no space, no permission) and the path; what was at `path` before is then untouched. A device or a pipe at
// `path` is written to.
void write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace subpixel::replay
