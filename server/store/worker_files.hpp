// The files a worker says it has written, read with the distrust due to a process that may have gone wrong.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "replay/results/results.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

constexpr std::size_t kMaxImages = 64;                            // of a result
constexpr std::uint64_t kMaxImageBytes = std::uint64_t{1} << 29;  // SQLite holds blobs up to 1e9 bytes

// By the end of its name, since what a worker says of it is not to be trusted either.
std::string media_type_of(std::string_view file_name);

// The bytes of each image `result` names, by role; all are plain files in `folder`. Throws InputError.
std::map<std::string, Blob> read_worker_images(const std::filesystem::path& folder, const replay::FrameResult& result);

}  // namespace subpixel::server
