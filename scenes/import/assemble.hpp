// Puts the pieces of a scene description into a SceneBuilder. Private to import.cpp.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scenes/builder/scene_builder.hpp"
#include "scenes/import/model.hpp"
#include "scenes/import/scene_description.hpp"

namespace subpixel::capture {

// Adds the model's textures and materials; the numbers of its materials in the scene.
std::vector<std::uint32_t> add_materials(SceneBuilder& scene, const Model& model);

// Draws ground, grass and placed models in this order, and adds the models' lights to the environment. `folders` are
// searched in order for archives and model files. Throws InputError naming what is missing.
void assemble(SceneBuilder& scene, const SceneDescription& description,
              const std::vector<std::filesystem::path>& folders,
              const std::function<void(const std::string&)>& progress);

}  // namespace subpixel::capture
