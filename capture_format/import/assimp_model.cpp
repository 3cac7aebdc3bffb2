#include "capture_format/import/assimp_model.hpp"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>

#include "capture_format/error.hpp"
#include "capture_format/import/assimp_materials.hpp"
#include "capture_format/import/text.hpp"

namespace subpixel::capture {
namespace {

class MemoryStream final : public Assimp::IOStream {
 public:
  explicit MemoryStream(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
    if (offset > bytes_.size() - base) return aiReturn_FAILURE;
    at_ = base + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
};

// Lets assimp read from an AssetSource, and remembers what it asked for in vain.
class SourceFiles final : public Assimp::IOSystem {
 public:
  SourceFiles(const AssetSource& source, std::vector<std::string>& missing) : source_(source), missing_(missing) {}

  bool Exists(const char* file) const override { return source_.contains(file); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char*) override {
    std::optional<std::vector<std::byte>> bytes = source_.read(file);
    if (!bytes) {
      missing_.emplace_back(file);
      return nullptr;
    }
    return std::make_unique<MemoryStream>(std::move(*bytes)).release();  // assimp gives it back to Close()
  }
  void Close(Assimp::IOStream* stream) override { const std::unique_ptr<Assimp::IOStream> owned(stream); }

 private:
  const AssetSource& source_;
  std::vector<std::string>& missing_;
};

glm::dvec3 to_vec3(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}
Float3 to_float3(const aiColor3D& c) {
  return {std::max(c.r, 0.0f), std::max(c.g, 0.0f), std::max(c.b, 0.0f)};
}

glm::dmat4 to_matrix(const aiMatrix4x4& m) {
  glm::dmat4 matrix(1.0);
  for (unsigned r = 0; r < 4; ++r) {
    for (unsigned c = 0; c < 4; ++c) matrix[static_cast<int>(c)][static_cast<int>(r)] = m[r][c];
  }
  return matrix;
}

Mesh to_mesh(const aiMesh& from) {
  Mesh mesh;
  mesh.positions.reserve(from.mNumVertices);
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const glm::dvec3 normal = from.mNormals != nullptr ? to_vec3(from.mNormals[i]) : glm::dvec3(0);
    const double length = glm::length(normal);
    const aiVector3D uv = from.HasTextureCoords(0) ? from.mTextureCoords[0][i] : aiVector3D(0, 0, 0);
    // A normal of length 0 or NaN, as degenerate triangles give, would turn into NaN on the way to snorm.
    mesh.add_vertex(to_vec3(from.mVertices[i]), length > 0 ? normal / length : glm::dvec3(0, 1, 0), {uv.x, uv.y});
  }
  for (unsigned f = 0; f < from.mNumFaces; ++f) {
    const aiFace& face = from.mFaces[f];
    if (face.mNumIndices == 3) mesh.add_triangle(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
  }
  return mesh;
}

void add_lights(const aiScene& scene, Model& model) {
  for (unsigned i = 0; i < scene.mNumLights; ++i) {
    const aiLight& light = *scene.mLights[i];
    const aiNode* node = scene.mRootNode->FindNode(light.mName);
    glm::dmat4 place(1.0);
    for (; node != nullptr; node = node->mParent) place = to_matrix(node->mTransformation) * place;
    if (light.mType == aiLightSource_DIRECTIONAL) {
      const glm::dvec3 direction = glm::dmat3(place) * to_vec3(light.mDirection);
      if (!(glm::length(direction) > 0)) continue;
      model.sun = DirectionalLight{
          {static_cast<float>(direction.x), static_cast<float>(direction.y), static_cast<float>(direction.z)},
          to_float3(light.mColorDiffuse),
          true};
    } else if (light.mType == aiLightSource_POINT) {
      const glm::dvec3 at(place * glm::dvec4(to_vec3(light.mPosition), 1));
      PointLight point;
      point.position = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
      point.intensity = to_float3(light.mColorDiffuse);
      // Far enough that the window hides less than 1% of what the sun of a default scene gives.
      const float brightest = std::max({point.intensity[0], point.intensity[1], point.intensity[2], 1e-6f});
      point.range = std::sqrt(brightest / 0.03f);
      model.point_lights.push_back(point);
    }
  }
}

void add_camera(const aiScene& scene, Model& model) {
  if (scene.mNumCameras == 0) return;
  const aiCamera& camera = *scene.mCameras[0];
  const aiNode* const own_node = scene.mRootNode->FindNode(camera.mName);
  const glm::dvec3 position = to_vec3(camera.mPosition);
  glm::dmat4 place(1.0);
  for (const aiNode* node = own_node; node != nullptr; node = node->mParent) {
    place = to_matrix(node->mTransformation) * place;
  }
  const glm::dvec3 eye(place * glm::dvec4(position, 1));
  const glm::dvec3 ahead = glm::dmat3(place) * to_vec3(camera.mLookAt);
  const glm::dvec3 up = glm::dmat3(place) * to_vec3(camera.mUp);
  const glm::dvec3 across = glm::cross(ahead, up);
  if (!(glm::length(across) > 0)) return;
  ModelCamera found;
  found.world[0] = glm::dvec4(glm::normalize(across), 0);
  found.world[1] = glm::dvec4(glm::normalize(glm::cross(across, ahead)), 0);
  found.world[2] = glm::dvec4(-glm::normalize(ahead), 0);
  found.world[3] = glm::dvec4(eye, 1);
  // The whole horizontal angle, in spite of assimp's documentation.
  const double aspect = camera.mAspect > 0 ? camera.mAspect : 1.0;
  const double vertical = 2 * std::atan(std::tan(static_cast<double>(camera.mHorizontalFOV) / 2) / aspect);
  found.vertical_fov_degrees = std::clamp(vertical * 180 / kPi, 5.0, 120.0);
  model.camera = found;
}

void place_nodes(const aiNode& node, const glm::dmat4& parent, const std::vector<std::size_t>& part_of_mesh,
                 Model& model) {
  const glm::dmat4 place = parent * to_matrix(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const std::size_t part = part_of_mesh[node.mMeshes[i]];
    if (part < model.parts.size()) model.parts[part].placements.push_back(place);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) place_nodes(*node.mChildren[i], place, part_of_mesh, model);
}

void require_no_missing_materials(const std::vector<std::string>& missing, const AssetSource& source,
                                  const std::string& name) {
  for (const std::string& file : missing) {
    if (file.ends_with(".mtl")) {
      throw InputError("can't import " + name, "the material file " + file + " is missing", source.describe(file));
    }
  }
}

}  // namespace

Model load_with_assimp(const AssetSource& source, const std::string& name) {
  std::vector<std::string> missing;
  Assimp::Importer importer;
  importer.SetIOHandler(std::make_unique<SourceFiles>(source, missing).release());  // the importer owns it
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 60.0f);
  const aiScene* scene =
      importer.ReadFile(name, aiProcess_Triangulate | aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices |
                                  aiProcess_SortByPType | aiProcess_FlipUVs | aiProcess_GenUVCoords |
                                  aiProcess_TransformUVCoords | aiProcess_ValidateDataStructure);
  require_no_missing_materials(missing, source, name);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw InputError("can't import the model", to_utf8(importer.GetErrorString()), source.describe(name));
  }

  Model model;
  model.name = to_utf8(std::filesystem::path(name).stem().string());
  add_materials(*scene, source, name, model);
  std::vector<std::size_t> part_of_mesh(scene->mNumMeshes, std::numeric_limits<std::size_t>::max());
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& mesh = *scene->mMeshes[i];
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) continue;
    ModelPart part{to_utf8(mesh.mName.C_Str()), to_mesh(mesh), mesh.mMaterialIndex, {}};
    if (part.name.empty()) part.name = model.name;
    if (model.materials[part.material].normal_texture != kNone && mesh.HasTextureCoords(0)) compute_tangents(part.mesh);
    part_of_mesh[i] = model.parts.size();
    model.parts.push_back(std::move(part));
  }
  place_nodes(*scene->mRootNode, glm::dmat4(1.0), part_of_mesh, model);
  std::erase_if(model.parts, [](const ModelPart& part) { return part.placements.empty(); });
  if (model.parts.empty()) {
    throw InputError("can't import the model", "it has no triangles", source.describe(name));
  }
  add_lights(*scene, model);
  add_camera(*scene, model);
  return model;
}

}  // namespace subpixel::capture
