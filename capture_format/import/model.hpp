// One model file (glTF, GLB, OBJ, ...) read by assimp into meshes, materials and textures of our own form.
#pragma once

#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/camera.hpp"
#include "capture_format/capture.hpp"
#include "capture_format/import/asset_source.hpp"
#include "capture_format/mesh.hpp"

namespace subpixel::capture {

struct ModelPart {
  std::string name;
  Mesh mesh;
  std::uint32_t material = 0;          // in Model::materials
  std::vector<glm::dmat4> placements;  // at least one
};

struct Model {
  std::string name;
  std::vector<ModelPart> parts;
  std::vector<Material> materials;  // texture numbers are those of `textures`
  std::vector<Texture> textures;
  std::vector<PointLight> point_lights;
  std::optional<DirectionalLight> sun;
  std::optional<CameraKey> camera;         // the file's first
  glm::dvec3 low{0, 0, 0}, high{0, 0, 0};  // bounds of all placed parts
};

// Reads `name` from `source`, with the materials and textures it refers to. Texture files are kept as found; normals
// are made smooth where they are missing, tangents made where there is a normal map. Alpha-tested materials are
// two-sided. Throws InputError naming the model or texture that is missing, damaged or too large.
Model load_model(const AssetSource& source, const std::string& name);

// Joins all parts of one material into one, their placements applied: for models that are placed as a whole.
void merge_parts(Model& model);

}  // namespace subpixel::capture
