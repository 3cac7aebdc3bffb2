// Materials and textures of an assimp scene in our form. Private to assimp_model.cpp.
#pragma once

#include <string>

#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

struct aiScene;

namespace subpixel::capture {

// Appends to model.materials one material for each of the scene's, and the textures they use to model.textures, each
// file once. `model_name` is the model's own file, which texture names are relative to. A texture that is missing is
// left out with a notice, and a material of opacity 0 is read as opaque. Throws InputError naming a texture that is
// damaged.
void add_materials(const aiScene& scene, const AssetSource& source, const std::string& model_name, Model& model);

}  // namespace subpixel::capture
