// The files a worker says it has written, read with the distrust due to a process that may have gone wrong.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "replay/results/results.hpp"
#include "server/store/store.hpp"

namespace subpixel::server {

// The bytes of each image `result` names, by role; all are plain files in `folder`. Throws InputError.
std::map<std::string, Blob> read_worker_images(const std::filesystem::path& folder, const replay::FrameResult& result);

}  // namespace subpixel::server
