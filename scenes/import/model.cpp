#include "scenes/import/model.hpp"

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "scenes/import/assimp_model.hpp"
#include "scenes/import/gltf.hpp"
#include "scenes/import/obj.hpp"
#include "scenes/import/statements.hpp"

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
  const std::string extension = lower_case(std::filesystem::path(name).extension().string());
  const auto load = extension == ".obj"                           ? &load_obj
                    : extension == ".gltf" || extension == ".glb" ? &load_gltf
                                                                  : &load_with_assimp;
  Model model = load(source, name);
  if (model.parts.empty()) throw InputError("can't import the model", "it has no triangles", source.describe(name));
  find_bounds(model);
  if (!(model.low.x <= model.high.x)) {
    throw InputError("can't import the model", "no vertex of its triangles has a usable position",
                     source.describe(name));
  }
  return model;
}

namespace {

// Appends a part where one of its placements has it. Attributes that one of the two lacks are filled in: colours with
// white, second uvs with 0.
void append_placed(Mesh& whole, const Mesh& part, const glm::dmat4& place) {
  const auto first = static_cast<std::uint32_t>(whole.positions.size());
  const glm::dmat3 linear(place);
  const double turn = glm::determinant(linear) < 0 ? -1 : 1;  // a mirror image turns the other way round
  // The cofactors are the inverse's transpose up to a factor, and there for a flattened part, too.
  const glm::dmat3 for_normals(glm::cross(linear[1], linear[2]) * turn, glm::cross(linear[2], linear[0]) * turn,
                               glm::cross(linear[0], linear[1]) * turn);
  const auto unit_or = [](const glm::dvec3& vector, const glm::dvec3& other) {
    const double length = glm::length(vector);
    return length > 0 && std::isfinite(length) ? vector / length : other;
  };
  if (!part.uvs2.empty()) whole.uvs2.resize(first, glm::dvec2(0));
  if (!part.colours.empty()) whole.colours.resize(first, glm::vec4(1));
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    whole.add_vertex(glm::dvec3(place * glm::dvec4(part.positions[i], 1)),
                     unit_or(for_normals * part.normals[i], part.normals[i]), part.uvs[i]);
    if (!part.tangents.empty()) {
      const glm::dvec3 tangent(part.tangents[i]);
      whole.tangents.emplace_back(unit_or(linear * tangent, tangent), part.tangents[i].w * turn);
    }
  }
  whole.uvs2.insert(whole.uvs2.end(), part.uvs2.begin(), part.uvs2.end());
  whole.colours.insert(whole.colours.end(), part.colours.begin(), part.colours.end());
  if (!whole.uvs2.empty()) whole.uvs2.resize(whole.positions.size(), glm::dvec2(0));
  if (!whole.colours.empty()) whole.colours.resize(whole.positions.size(), glm::vec4(1));
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    const std::uint32_t a = first + part.indices[i], b = first + part.indices[i + 1], c = first + part.indices[i + 2];
    whole.indices.insert(whole.indices.end(), {a, turn < 0 ? c : b, turn < 0 ? b : c});
  }
}

}  // namespace

void merge_parts(Model& model) {
  std::map<std::uint32_t, ModelPart> merged;
  for (ModelPart& part : model.parts) {
    // With tangents everywhere or nowhere in a material.
    if (model.materials[part.material].normal_texture != kNone && part.mesh.tangents.empty()) {
      compute_tangents(part.mesh);
    }
    ModelPart& whole = merged[part.material];
    whole.material = part.material;
    whole.placements = {glm::dmat4(1.0)};
    for (const glm::dmat4& place : part.placements) append_placed(whole.mesh, part.mesh, place);
  }
  model.parts.clear();
  for (auto& [material, part] : merged) {
    part.name = model.materials[material].name;
    // Tangents that some part of a material without a normal map came with are of no use.
    if (part.mesh.tangents.size() != part.mesh.positions.size()) part.mesh.tangents.clear();
    model.parts.push_back(std::move(part));
  }
}

}  // namespace subpixel::capture
