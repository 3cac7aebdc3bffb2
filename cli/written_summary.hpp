// What verbs that write a capture say of it.
#pragma once

#include <filesystem>
#include <string>

#include "capture_format/capture.hpp"

namespace subpixel::cli {

// "N frames, ..., hash H" of a capture that was just written to `path`.
std::string written_summary(const capture::Capture& made, const std::filesystem::path& path);

}  // namespace subpixel::cli
