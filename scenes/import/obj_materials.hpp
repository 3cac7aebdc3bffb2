// Materials of MTL files in our form. Private to the OBJ loader.
#pragma once

#include <string>
#include <vector>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"
#include "scenes/import/obj_text.hpp"

namespace subpixel::capture {

// Appends the materials of all libraries that the file names to model.materials, in their order, then those it uses
// and no library has; textures of those it uses to model.textures; what was left out to model.notices. Returns for
// each of obj.materials its number in model.materials. `model_name` is the OBJ file's own, which library names are
// relative to; names of textures are relative to their library, else to the OBJ file. Throws InputError naming a
// texture or a library that is needed and missing, and what in a file is wrong.
std::vector<std::uint32_t> add_obj_materials(const ObjText& obj, const AssetSource& source,
                                             const std::string& model_name, Model& model);

}  // namespace subpixel::capture
