// glTF 2.0 and GLB files: all of the core specification but points, lines and occlusion textures, and the extensions
// that gltf.cpp lists. The document is read with nlohmann-json and what it compresses by draco and meshoptimizer; the
// rest is short, and a loader in between (tinygltf 2.7 was tried) refuses buffers that are longer than they say or that
// only stand for a compressed view, takes '+' in file names for a blank, and can't name the element that is wrong.
// Private to model.cpp.
#pragma once

#include <string>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

namespace subpixel::capture {

// All of the model but its bounds, as it is at the start of its first animation where it has one. Throws InputError
// naming file, element and value.
Model load_gltf(const AssetSource& source, const std::string& name);

}  // namespace subpixel::capture
