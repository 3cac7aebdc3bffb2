// RenderDoc captures by python/subpixel_renderdoc, which this program carries with it: it runs in the system's Python,
// whose module `renderdoc` replays them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::cli {

// What import-worker hands on to the exporter.
struct RenderDocOptions {
  std::vector<std::string> more;       // further .rdc files: a frame each, after the first
  std::vector<std::string> arguments;  // of the exporter, verbatim: --events=..., --sun=...
  bool on_display = false;             // by the display and the drivers found here; otherwise without a display
};

bool is_renderdoc(const std::filesystem::path& path);

// The capture of a .rdc file. Runs the exporter, whose progress lines go to standard output as JSON documents. The
// Python is python_interpreter()'s. Files are made in a folder of its
// own under `scratch` and removed. Throws InputError with the exporter's or the system's reason.
capture::Capture import_renderdoc(const std::string& in, const RenderDocOptions& options,
                                  const std::filesystem::path& scratch);

}  // namespace subpixel::cli
