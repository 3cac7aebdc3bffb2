// The viewer, embedded by the build.
#pragma once

#include <span>

#include "base/embedded_file.hpp"

namespace subpixel::web {

// The files of this folder, by name.
std::span<const EmbeddedFile> files();

}  // namespace subpixel::web
