// The sources of the packages in this folder, compiled in.
#pragma once

#include <span>

#include "base/embedded_file.hpp"

namespace subpixel::python {

std::span<const EmbeddedFile> capture_files();    // of subpixel_capture
std::span<const EmbeddedFile> renderdoc_files();  // of subpixel_renderdoc

}  // namespace subpixel::python
