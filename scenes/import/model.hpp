// One model file (glTF, GLB, OBJ, ...) as meshes, materials and textures of our own form.
#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/builder/mesh.hpp"
#include "scenes/import/asset_source.hpp"

namespace subpixel::capture {

struct ModelPart {
  std::string name;
  Mesh mesh;                           // normals always; tangents where the material has a normal map and there are uvs
  std::uint32_t material = 0;          // in Model::materials
  std::vector<glm::dmat4> placements;  // at least one
  bool instanced = false;              // drawn by one call with instances, else by a call for each placement
};

// Seen from the origin of `world` along its -z, +y up.
struct ModelCamera {
  glm::dmat4 world{1.0};
  bool orthographic = false;
  double vertical_fov_degrees = 50;        // perspective
  double half_width = 1, half_height = 1;  // orthographic, world units
  std::optional<double> near, far;         // world units; absent: by the scene's size, none
};

struct Model;

// A model that moves: sets placements, deformed meshes, lights, camera and bounds of the model it came with.
class ModelAnimation {
 public:
  ModelAnimation() = default;
  ModelAnimation(const ModelAnimation&) = delete;
  ModelAnimation& operator=(const ModelAnimation&) = delete;
  virtual ~ModelAnimation() = default;

  virtual double duration_s() const = 0;
  virtual void pose(double time_s, Model& model) const = 0;
};

struct Model {
  std::string name;
  std::vector<ModelPart> parts;
  std::vector<Material> materials;  // texture numbers are those of `textures`
  std::vector<Texture> textures;
  std::vector<PointLight> point_lights;  // spots too
  std::optional<DirectionalLight> sun;
  std::optional<ModelCamera> camera;       // the file's first that is placed
  glm::dvec3 low{0, 0, 0}, high{0, 0, 0};  // bounds of all placed parts
  std::vector<std::string> notices;        // what of the file was left out or approximated: "ignored: ..."
  std::shared_ptr<const ModelAnimation> animation{};
};

// Reads `name` from `source`, with the materials and textures it refers to: glTF and GLB by gltf.hpp, OBJ by obj.hpp,
// all else by assimp. Texture files are kept as found; normals are made where they are missing (glTF: flat; others: by
// a crease angle), tangents where there is a normal map. Throws InputError naming file, element and value that is
// missing, damaged or too large.
Model load_model(const AssetSource& source, const std::string& name);

// Sets low and high from the placed parts; positions that are not finite, or beyond 1e12, are left out.
void find_bounds(Model& model);

// Joins all parts of one material into one, their placements applied: for models that are placed as a whole.
void merge_parts(Model& model);

}  // namespace subpixel::capture
