// Wavefront OBJ with its MTL libraries. Private to model.cpp.
#pragma once

#include <string>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

namespace subpixel::capture {

// All of the model but its bounds: one part for each object or group and material. Throws InputError naming file, line
// and value that is wrong or missing.
Model load_obj(const AssetSource& source, const std::string& name);

}  // namespace subpixel::capture
