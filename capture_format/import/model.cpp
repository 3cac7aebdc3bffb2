#include "capture_format/import/model.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>

#include "capture_format/error.hpp"
#include "capture_format/import/assimp_model.hpp"
#include "capture_format/import/gltf.hpp"

namespace subpixel::capture {

namespace {

// A vertex farther away is a mistake of the file's: it is drawn as it is, but no camera looks for it.
constexpr double kFarthest = 1e12;

}  // namespace

void find_bounds(Model& model) {
  model.low = glm::dvec3(std::numeric_limits<double>::infinity());
  model.high = -model.low;
  for (const ModelPart& part : model.parts) {
    for (const glm::dmat4& place : part.placements) {
      for (const glm::dvec3& position : part.mesh.positions) {
        const glm::dvec3 at(place * glm::dvec4(position, 1));
        if (!(glm::length(at) <= kFarthest)) continue;  // NaN, too
        model.low = glm::min(model.low, at);
        model.high = glm::max(model.high, at);
      }
    }
  }
}

Model load_model(const AssetSource& source, const std::string& name) {
  if (!source.contains(name)) {
    throw InputError("can't import the model", "there is no such file", source.describe(name));
  }
  std::string extension = std::filesystem::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool is_gltf = extension == ".gltf" || extension == ".glb";
  Model model = is_gltf ? load_gltf(source, name) : load_with_assimp(source, name);
  if (model.parts.empty()) throw InputError("can't import the model", "it has no triangles", source.describe(name));
  find_bounds(model);
  if (!(model.low.x <= model.high.x)) {
    throw InputError("can't import the model", "no vertex of its triangles has a usable position", source.describe(name));
  }
  return model;
}

void merge_parts(Model& model) {
  std::map<std::uint32_t, ModelPart> merged;
  for (const ModelPart& part : model.parts) {
    ModelPart& whole = merged[part.material];
    whole.material = part.material;
    whole.placements = {glm::dmat4(1.0)};
    for (const glm::dmat4& place : part.placements) {
      const auto first = static_cast<std::uint32_t>(whole.mesh.positions.size());
      const glm::dmat3 normal_matrix = glm::transpose(glm::inverse(glm::dmat3(place)));
      for (std::size_t i = 0; i < part.mesh.positions.size(); ++i) {
        whole.mesh.add_vertex(glm::dvec3(place * glm::dvec4(part.mesh.positions[i], 1)),
                              glm::normalize(normal_matrix * part.mesh.normals[i]), part.mesh.uvs[i]);
      }
      for (const std::uint32_t index : part.mesh.indices) whole.mesh.indices.push_back(first + index);
    }
  }
  model.parts.clear();
  for (auto& [material, part] : merged) {
    part.name = model.materials[material].name;
    if (model.materials[material].normal_texture != kNone) compute_tangents(part.mesh);
    model.parts.push_back(std::move(part));
  }
}

}  // namespace subpixel::capture
