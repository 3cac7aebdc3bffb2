#include "scenes/import/assimp_model.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/error.hpp"
#include "scenes/import/assimp_lights.hpp"
#include "scenes/import/assimp_materials.hpp"
#include "scenes/import/assimp_values.hpp"
#include "scenes/import/material_values.hpp"
#include "scenes/import/normals.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"
#include "scenes/import/vertex_join.hpp"

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

// Lets assimp read from an AssetSource.
class SourceFiles final : public Assimp::IOSystem {
 public:
  explicit SourceFiles(const AssetSource& source) : source_(source) {}

  bool Exists(const char* file) const override { return source_.contains(file); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char*) override {
    std::optional<std::vector<std::byte>> bytes = source_.read(file);
    if (!bytes) return nullptr;
    return std::make_unique<MemoryStream>(std::move(*bytes)).release();  // assimp gives it back to Close()
  }
  void Close(Assimp::IOStream* stream) override { const std::unique_ptr<Assimp::IOStream> owned(stream); }

 private:
  const AssetSource& source_;
};

// Vertex colours of the formats that assimp reads are those of a screen or scanner.
glm::vec4 to_colour(const aiColor4D& c) {
  return {linear_of_srgb(c.r), linear_of_srgb(c.g), linear_of_srgb(c.b), unit(c.a)};
}

void require_sound(const aiScene& scene, const aiMesh& mesh, const std::string& where) {
  const auto fail = [&](const std::string& why) {
    throw InputError("can't import the model", why, fmt::format("{}, mesh \"{}\"", where, to_utf8(mesh.mName.C_Str())));
  };
  if (mesh.mMaterialIndex >= scene.mNumMaterials) {
    fail(fmt::format("its material {} is out of range: there are {}", mesh.mMaterialIndex, scene.mNumMaterials));
  }
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& p = mesh.mVertices[i];
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
    fail(fmt::format("position {} is ({}, {}, {}), which is not finite", i, p.x, p.y, p.z));
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mIndices == nullptr) fail(fmt::format("face {} has no indices", f));
    for (unsigned i = 0; i < face.mNumIndices; ++i) {
      if (face.mIndices[i] < mesh.mNumVertices) continue;
      fail(fmt::format("index {} of face {} is out of range: there are {} vertices", face.mIndices[i], f,
                       mesh.mNumVertices));
    }
  }
}

// Recursion as deep as the file's tree, as assimp's own.
void require_sound(const aiScene& scene, const aiNode* node, const std::string& where) {
  if (node == nullptr) throw InputError("can't import the model", "the reader made a node of nothing", where);
  for (unsigned i = 0; i < node->mNumMeshes; ++i) {
    if (node->mMeshes[i] < scene.mNumMeshes) continue;
    throw InputError("can't import the model",
                     fmt::format("mesh {} of a node is out of range: there are {}", node->mMeshes[i], scene.mNumMeshes),
                     fmt::format("{}, node \"{}\"", where, to_utf8(node->mName.C_Str())));
  }
  for (unsigned i = 0; i < node->mNumChildren; ++i) require_sound(scene, node->mChildren[i], where);
}

// What is used of a scene must be there, in range and finite: assimp hands on what it read.
void require_sound(const aiScene& scene, const std::string& where) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) require_sound(scene, *scene.mMeshes[i], where);
  require_sound(scene, scene.mRootNode, where);
}

Mesh to_mesh(const aiMesh& from) {
  Mesh mesh;
  mesh.positions.reserve(from.mNumVertices);
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    aiVector3D uv = from.HasTextureCoords(0) ? from.mTextureCoords[0][i] : aiVector3D(0, 0, 0);
    if (!std::isfinite(uv.x + uv.y)) uv = {0, 0, 0};
    mesh.add_vertex(to_vec3(from.mVertices[i]), from.HasNormals() ? to_vec3(from.mNormals[i]) : glm::dvec3(0),
                    {uv.x, uv.y});
    if (from.HasVertexColors(0)) mesh.colours.push_back(to_colour(from.mColors[0][i]));
  }
  for (unsigned f = 0; f < from.mNumFaces; ++f) {
    const aiFace& face = from.mFaces[f];
    if (face.mNumIndices == 3) mesh.add_triangle(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
  }
  join_equal_vertices(mesh);
  make_missing_normals(mesh);
  return mesh;
}

// `part_of_mesh` has a number that no part has for meshes without triangles.
void place_nodes(const aiNode& node, const glm::dmat4& parent, const std::vector<std::size_t>& part_of_mesh,
                 Model& model) {
  const glm::dmat4 place = parent * to_matrix(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const std::size_t part = part_of_mesh[node.mMeshes[i]];
    if (part < model.parts.size()) model.parts[part].placements.push_back(place);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) place_nodes(*node.mChildren[i], place, part_of_mesh, model);
}

}  // namespace

Model load_with_assimp(const AssetSource& source, const std::string& name) {
  const std::string where = source.describe(name);
  Assimp::Importer importer;
  importer.SetIOHandler(std::make_unique<SourceFiles>(source).release());  // the importer owns it
  // Post-processing trusts what was read: that is checked before.
  const aiScene* scene = importer.ReadFile(name, 0);
  const auto fail = [&] {
    const std::string reason = importer.GetErrorString();
    throw InputError("can't import the model", reason.empty() ? "the reader gave no reason" : to_utf8(reason), where);
  };
  if (scene == nullptr || scene->mRootNode == nullptr) fail();
  require_sound(*scene, where);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_FlipUVs | aiProcess_GenUVCoords |
                                       aiProcess_TransformUVCoords);
  if (scene == nullptr) fail();

  const std::string extension = lower_case(std::filesystem::path(name).extension().string());
  const bool has_bare_meshes = extension == ".ply" || extension == ".off" || extension == ".stl";
  Model model;
  model.name = to_utf8(std::filesystem::path(name).stem().string());
  add_materials(*scene, source, name, model);
  std::vector<std::size_t> part_of_mesh(scene->mNumMeshes, std::numeric_limits<std::size_t>::max());
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& mesh = *scene->mMeshes[i];
    if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0 || mesh.mNumVertices == 0) continue;
    ModelPart part{to_utf8(mesh.mName.C_Str()), to_mesh(mesh), mesh.mMaterialIndex, {}};
    if (part.name.empty()) part.name = model.name;
    Material& material = model.materials[part.material];
    // Each reader of assimp's has another look for meshes without a material, and not all name it.
    const bool is_made_up =
        material.name == kDefaultMaterialName || scene->mMaterials[mesh.mMaterialIndex]->GetName().length == 0;
    if (has_bare_meshes && is_made_up && material.base_colour_texture == kNone) {
      const bool two_sided = material.two_sided;
      material = default_material(kDefaultMaterialName, mesh.HasVertexColors(0));
      material.two_sided = two_sided;
    }
    if (material.normal_texture != kNone && mesh.HasTextureCoords(0)) compute_tangents(part.mesh);
    part_of_mesh[i] = model.parts.size();
    model.parts.push_back(std::move(part));
  }
  place_nodes(*scene->mRootNode, glm::dmat4(1.0), part_of_mesh, model);
  std::erase_if(model.parts, [](const ModelPart& part) { return part.placements.empty(); });
  if (model.parts.empty()) {
    throw InputError("can't import the model", "it has no triangles", where);
  }
  find_bounds(model);
  add_assimp_lights(*scene, model);
  add_assimp_camera(*scene, model);
  return model;
}

}  // namespace subpixel::capture
