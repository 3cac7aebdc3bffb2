// Model files of other formats, read by assimp. Private to model.cpp.
#pragma once

#include <string>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

namespace subpixel::capture {

// All of the model but its bounds. Throws InputError with assimp's reason. assimp crashes and hangs on some damaged
// files: what comes from outside is given to it in a process that may.
Model load_with_assimp(const AssetSource& source, const std::string& name);

}  // namespace subpixel::capture
