// Which textures are one. Private to the recorders.
#pragma once

#include <string>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

// Equal for textures of equal texels, encoding and sampler, whatever their names.
std::string texture_key(const Texture& texture);

}  // namespace subpixel::capture
