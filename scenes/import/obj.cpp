#include "scenes/import/obj.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"
#include "scenes/import/material_values.hpp"
#include "scenes/import/normals.hpp"
#include "scenes/import/obj_materials.hpp"
#include "scenes/import/obj_text.hpp"
#include "scenes/import/polygon.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

struct CornerHash {
  std::size_t operator()(const ObjCorner& corner) const {
    std::uint64_t hash = corner.position * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 32) ^ corner.uv) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ (hash >> 32) ^ corner.normal) * 0x94d049bb133111ebu;
    return hash ^ (hash >> 32);
  }
};

// The faces of one object with what was said of each triangle.
struct ObjectMesh {
  Mesh mesh;
  std::vector<std::uint32_t> materials;   // of each triangle, in ObjText::materials
  std::vector<SmoothingGroup> smoothing;  // of each triangle
};

class ObjectBuilder {
 public:
  ObjectBuilder(const ObjText& obj, std::string where) : obj_(obj), where_(std::move(where)) {}

  ObjectMesh build(const std::vector<std::uint32_t>& faces) {
    result_ = {};
    vertices_.clear();
    for (const std::uint32_t face : faces) add_face(obj_.faces[face]);
    return std::move(result_);
  }

 private:
  void add_face(const ObjFace& face) {
    polygon_.clear();
    for (std::uint32_t i = 0; i < face.corner_count; ++i) {
      polygon_.push_back(obj_.positions[obj_.corners[face.first_corner + i].position]);
    }
    triangles_.clear();
    if (!triangulate(polygon_, triangles_)) {
      throw InputError(
          "can't import the model",
          fmt::format("a concave face has {} corners, more than {}", face.corner_count, kMaxConcaveCorners),
          fmt::format("{}, line {}", where_, face.line));
    }
    for (const std::uint32_t corner : triangles_) {
      result_.mesh.indices.push_back(vertex_of(obj_.corners[face.first_corner + corner]));
    }
    result_.materials.resize(result_.mesh.triangle_count(), face.material);
    result_.smoothing.resize(result_.mesh.triangle_count(), face.smoothing);
  }

  std::uint32_t vertex_of(const ObjCorner& corner) {
    Mesh& mesh = result_.mesh;
    const auto [known, is_new] = vertices_.try_emplace(corner, static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) {
      // v = 0 is the image's top row.
      const glm::dvec2 uv = corner.uv == kNoElement ? glm::dvec2(0, 1) : obj_.uvs[corner.uv];
      mesh.add_vertex(obj_.positions[corner.position],
                      corner.normal == kNoElement ? glm::dvec3(0) : obj_.normals[corner.normal], {uv.x, 1 - uv.y});
      if (!obj_.colours.empty()) {
        const glm::vec3& colour = obj_.colours[corner.position];
        mesh.colours.emplace_back(linear_of_srgb(colour.r), linear_of_srgb(colour.g), linear_of_srgb(colour.b), 1);
      }
    }
    return known->second;
  }

  const ObjText& obj_;
  std::string where_;
  ObjectMesh result_;
  std::unordered_map<ObjCorner, std::uint32_t, CornerHash> vertices_;
  std::vector<glm::dvec3> polygon_;
  std::vector<std::uint32_t> triangles_;
};

// The object's triangles by material, in the order in which its materials come.
std::vector<std::pair<std::uint32_t, std::vector<std::size_t>>> triangles_by_material(const ObjectMesh& object) {
  std::vector<std::pair<std::uint32_t, std::vector<std::size_t>>> lists;
  std::unordered_map<std::uint32_t, std::size_t> list_of;
  for (std::size_t t = 0; t < object.materials.size(); ++t) {
    const auto [list, is_new] = list_of.try_emplace(object.materials[t], lists.size());
    if (is_new) lists.push_back({object.materials[t], {}});
    lists[list->second].second.push_back(t);
  }
  return lists;
}

// Some triangles of a mesh with the vertices that they use, in the order of use. `new_numbers` has kNoElement for each
// vertex before and after.
Mesh part_of(const Mesh& from, const std::vector<std::size_t>& triangles, std::vector<std::uint32_t>& new_numbers) {
  Mesh mesh;
  for (const std::size_t t : triangles) {
    for (std::size_t i = 3 * t; i < 3 * t + 3; ++i) {
      const std::uint32_t vertex = from.indices[i];
      if (new_numbers[vertex] == kNoElement) {
        new_numbers[vertex] = mesh.add_vertex(from.positions[vertex], from.normals[vertex], from.uvs[vertex]);
        if (!from.colours.empty()) mesh.colours.push_back(from.colours[vertex]);
      }
      mesh.indices.push_back(new_numbers[vertex]);
    }
  }
  for (const std::size_t t : triangles) {
    for (std::size_t i = 3 * t; i < 3 * t + 3; ++i) new_numbers[from.indices[i]] = kNoElement;
  }
  return mesh;
}

}  // namespace

Model load_obj(const AssetSource& source, const std::string& name) {
  const std::string where = source.describe(name);
  std::optional<std::vector<std::byte>> file = source.read(name);
  if (!file) throw InputError("can't import the model", "there is no such file", where);
  ObjText obj = parse_obj(std::move(*file), where);
  if (obj.faces.empty()) throw InputError("can't import the model", "it has no faces", where);

  Model model;
  model.name = to_utf8(std::filesystem::path(name).stem().string());
  model.notices = std::move(obj.notices);
  const std::vector<std::uint32_t> materials = add_obj_materials(obj, source, name, model);
  std::vector<std::vector<std::uint32_t>> faces(obj.objects.size());
  for (std::uint32_t i = 0; i < obj.faces.size(); ++i) faces[obj.faces[i].object].push_back(i);
  ObjectBuilder builder(obj, where);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    // Normals of the whole object before it is parted, so that a round body of two materials has no seam.
    ObjectMesh object = builder.build(faces[i]);
    make_missing_normals(object.mesh, object.smoothing);
    std::vector<std::uint32_t> new_numbers(object.mesh.positions.size(), kNoElement);
    for (const auto& [material, triangles] : triangles_by_material(object)) {
      ModelPart part{obj.objects[i].empty() ? model.name : obj.objects[i],
                     part_of(object.mesh, triangles, new_numbers),
                     materials[material],
                     {glm::dmat4(1.0)}};
      if (model.materials[part.material].normal_texture != kNone) compute_tangents(part.mesh);
      model.parts.push_back(std::move(part));
    }
  }
  return model;
}

}  // namespace subpixel::capture
