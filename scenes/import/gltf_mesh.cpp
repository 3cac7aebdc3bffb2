#include "scenes/import/gltf_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "scenes/import/gltf_draco.hpp"
#include "scenes/import/normals.hpp"

namespace subpixel::capture {
namespace {

constexpr std::string_view kVec2[] = {"VEC2"}, kVec3[] = {"VEC3"}, kVec4[] = {"VEC4"}, kColour[] = {"VEC3", "VEC4"};

// A primitive's attributes by name, from accessors or from a compressed mesh.
class Attributes {
 public:
  Attributes(const GltfDocument& document, const GltfElement& primitive) : document_(document), primitive_(primitive) {
    if (const auto compressed = primitive.extension("KHR_draco_mesh_compression")) {
      draco_ = decode_draco(document, *compressed);
    }
  }

  std::optional<GltfValues> find(const std::string& name, std::span<const std::string_view> types) const {
    if (draco_) {
      const auto found = draco_->attributes.find(name);
      if (found != draco_->attributes.end()) return found->second;
    }
    const std::optional<GltfElement> list = primitive_.find("attributes");
    if (!list) return std::nullopt;
    const std::optional<std::size_t> accessor = list->find_index(name.c_str(), document_.count("accessors"));
    if (!accessor) return std::nullopt;
    return document_.values(*accessor, list->member(name.c_str()), types);
  }

  // Corner numbers in drawing order; all vertices in turn where the primitive has no indices.
  std::vector<std::uint32_t> corners(std::size_t vertices) const {
    if (draco_) return draco_->indices;
    if (const auto accessor = primitive_.find_index("indices", document_.count("accessors"))) {
      return document_.indices(*accessor, primitive_.member("indices"));
    }
    std::vector<std::uint32_t> all(vertices);
    for (std::size_t i = 0; i < vertices; ++i) all[i] = static_cast<std::uint32_t>(i);
    return all;
  }

  bool are_triangles() const { return draco_.has_value(); }

 private:
  const GltfDocument& document_;
  const GltfElement& primitive_;
  std::optional<DracoMesh> draco_;
};

void require_count(const GltfElement& primitive, const std::string& name, std::size_t count, std::size_t vertices) {
  if (count != vertices) primitive.fail(fmt::format("{} has {} elements, POSITION {}", name, count, vertices));
}

std::vector<glm::dvec3> vec3s(const GltfValues& values) {
  std::vector<glm::dvec3> result(values.count);
  for (std::size_t i = 0; i < values.count; ++i) result[i] = {values.at(i)[0], values.at(i)[1], values.at(i)[2]};
  return result;
}

std::vector<glm::dvec2> uvs_of(const Attributes& attributes, const GltfElement& primitive,
                               std::optional<std::size_t> set, const std::array<float, 6>& m, std::size_t vertices) {
  if (!set) return {};
  const std::string name = fmt::format("TEXCOORD_{}", *set);
  const std::optional<GltfValues> values = attributes.find(name, kVec2);
  if (!values) return {};
  require_count(primitive, name, values->count, vertices);
  std::vector<glm::dvec2> result(vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    const double u = values->at(i)[0], v = values->at(i)[1];
    result[i] = {m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
  }
  return result;
}

// Section 3.7.2.1: strips and fans as triangles of the same winding.
std::vector<std::uint32_t> triangles_of(const std::vector<std::uint32_t>& corners, std::uint64_t mode,
                                        const GltfElement& primitive) {
  constexpr std::uint64_t kTriangles = 4, kStrip = 5;
  if (mode == kTriangles) {
    if (corners.size() % 3 != 0) primitive.fail(fmt::format("{} corners are no triangles", corners.size()));
    return corners;
  }
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    if (mode == kStrip) {
      const std::size_t odd = i % 2;
      triangles.insert(triangles.end(), {corners[i - 2], corners[i - 1 + odd], corners[i - odd]});
    } else {
      triangles.insert(triangles.end(), {corners[i - 1], corners[i], corners[0]});
    }
  }
  return triangles;
}

void read_influences(const Attributes& attributes, const GltfElement& from, GltfPrimitive& primitive) {
  const std::size_t vertices = primitive.mesh.positions.size();
  std::vector<GltfValues> joints, weights;
  for (int set = 0;; ++set) {
    std::optional<GltfValues> j = attributes.find(fmt::format("JOINTS_{}", set), kVec4);
    std::optional<GltfValues> w = attributes.find(fmt::format("WEIGHTS_{}", set), kVec4);
    if (!j && !w) break;
    if (!j || !w) from.fail(fmt::format("JOINTS_{0} and WEIGHTS_{0} come together", set));
    require_count(from, fmt::format("JOINTS_{}", set), j->count, vertices);
    require_count(from, fmt::format("WEIGHTS_{}", set), w->count, vertices);
    joints.push_back(std::move(*j));
    weights.push_back(std::move(*w));
  }
  primitive.influences_per_vertex = 4 * joints.size();
  primitive.influences.reserve(vertices * primitive.influences_per_vertex);
  for (std::size_t i = 0; i < vertices; ++i) {
    double sum = 0;
    const std::size_t first = primitive.influences.size();
    for (std::size_t set = 0; set < joints.size(); ++set) {
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = weights[set].at(i)[k], joint = joints[set].at(i)[k];
        if (!(weight >= 0 && weight <= 1e6)) from.fail(fmt::format("weight {} of vertex {}", weight, i));
        if (!(joint >= 0 && joint < 65536 && joint == std::floor(joint)))
          from.fail(fmt::format("joint {} of vertex {}", joint, i));
        primitive.influences.push_back({static_cast<std::uint32_t>(joint), weight});
        sum += weight;
      }
    }
    for (std::size_t k = first; k < primitive.influences.size() && sum > 0; ++k) primitive.influences[k].weight /= sum;
  }
}

void read_targets(const GltfDocument& document, const GltfElement& from, GltfPrimitive& primitive) {
  const std::size_t vertices = primitive.mesh.positions.size();
  for (const GltfElement& target : from.elements("targets")) {
    MorphTarget read;
    const auto find = [&](const char* name) -> std::vector<glm::dvec3> {
      const std::optional<std::size_t> accessor = target.find_index(name, document.count("accessors"));
      if (!accessor) return {};
      const GltfValues values = document.values(*accessor, target.member(name), kVec3);
      require_count(target, name, values.count, vertices);
      return vec3s(values);
    };
    read.positions = find("POSITION");
    read.normals = find("NORMAL");
    read.tangents = find("TANGENT");
    primitive.targets.push_back(std::move(read));
  }
}

void apply_targets(const GltfPrimitive& primitive, std::span<const double> weights, Mesh& mesh) {
  for (std::size_t t = 0; t < primitive.targets.size() && t < weights.size(); ++t) {
    const MorphTarget& target = primitive.targets[t];
    if (weights[t] == 0) continue;
    for (std::size_t i = 0; i < target.positions.size(); ++i) mesh.positions[i] += weights[t] * target.positions[i];
    for (std::size_t i = 0; i < target.normals.size() && !mesh.normals.empty(); ++i) {
      mesh.normals[i] += weights[t] * target.normals[i];
    }
    for (std::size_t i = 0; i < target.tangents.size() && !mesh.tangents.empty(); ++i) {
      mesh.tangents[i] += glm::dvec4(weights[t] * target.tangents[i], 0);
    }
  }
}

// Section 3.7.3.3: each vertex by the weighted sum of its joints' matrices.
void apply_skin(const GltfPrimitive& primitive, std::span<const glm::dmat4> joints, Mesh& mesh) {
  const std::size_t per_vertex = primitive.influences_per_vertex;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    glm::dmat4 sum(0.0);
    for (std::size_t k = i * per_vertex; k < (i + 1) * per_vertex; ++k) {
      sum += primitive.influences[k].weight * joints[primitive.influences[k].joint];
    }
    mesh.positions[i] = glm::dvec3(sum * glm::dvec4(mesh.positions[i], 1));
    const glm::dmat3 linear(sum);
    // Cofactors: the inverse transpose but for its scale, without dividing by a determinant of 0.
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    if (!mesh.normals.empty()) mesh.normals[i] = cofactors * mesh.normals[i];
    if (!mesh.tangents.empty()) {
      mesh.tangents[i] = glm::dvec4(linear * glm::dvec3(mesh.tangents[i]), mesh.tangents[i].w);
    }
  }
}

// The UVs a normal map is read by decide its tangents.
void make_tangents(Mesh& mesh, const UvMapping& mapping) {
  Mesh read = mesh;
  if (mapping.set == 1 && !mesh.uvs2.empty()) read.uvs = mesh.uvs2;
  const std::array<float, 6>& m = mapping.matrix;
  for (glm::dvec2& uv : read.uvs) uv = {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
  compute_tangents(read);
  mesh.tangents = std::move(read.tangents);
}

}  // namespace

std::optional<GltfPrimitive> read_primitive(const GltfDocument& document, const GltfElement& from,
                                            const GltfMaterial& material) {
  constexpr std::uint64_t kFirstTriangles = 4, kLast = 6;
  const std::uint64_t mode = from.whole("mode", kFirstTriangles);
  if (mode > kLast) from.fail(fmt::format("unknown mode {}", mode));
  if (mode < kFirstTriangles) return std::nullopt;
  const Attributes attributes(document, from);
  const std::optional<GltfValues> positions = attributes.find("POSITION", kVec3);
  GltfPrimitive primitive;
  primitive.path = from.path();
  if (!positions) return primitive;  // nothing is drawn, says section 3.7.2.1
  Mesh& mesh = primitive.mesh;
  mesh.positions = vec3s(*positions);
  const std::size_t vertices = mesh.positions.size();
  if (const std::optional<GltfValues> normals = attributes.find("NORMAL", kVec3)) {
    require_count(from, "NORMAL", normals->count, vertices);
    mesh.normals = vec3s(*normals);
  }
  if (const std::optional<GltfValues> tangents = attributes.find("TANGENT", kVec4);
      tangents && material.material.normal_texture != kNone && !mesh.normals.empty()) {
    require_count(from, "TANGENT", tangents->count, vertices);
    mesh.tangents.resize(vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
      const double* t = tangents->at(i);
      mesh.tangents[i] = {t[0], t[1], t[2], t[3] < 0 ? -1.0 : 1.0};
    }
  }
  if (const std::optional<GltfValues> colours = attributes.find("COLOR_0", kColour)) {
    require_count(from, "COLOR_0", colours->count, vertices);
    mesh.colours.resize(vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
      const double* c = colours->at(i);
      for (int k = 0; k < 4; ++k) {
        const double value = k < static_cast<int>(colours->components) ? c[k] : 1.0;
        if (!(value >= 0 && value <= 1e6)) from.fail(fmt::format("COLOR_0 {} of vertex {}", value, i));
        mesh.colours[i][k] = static_cast<float>(value);
      }
    }
  }
  mesh.uvs = uvs_of(attributes, from, material.sets[0], material.baked, vertices);
  constexpr std::array<float, 6> kAsStored{1, 0, 0, 0, 1, 0};
  mesh.uvs2 = uvs_of(attributes, from, material.sets[1], kAsStored, vertices);
  mesh.indices = attributes.corners(vertices);
  if (!attributes.are_triangles()) mesh.indices = triangles_of(mesh.indices, mode, from);
  for (const std::uint32_t corner : mesh.indices) {
    if (corner >= vertices) from.fail(fmt::format("index {} of {} vertices", corner, vertices));
  }
  read_influences(attributes, from, primitive);
  read_targets(document, from, primitive);
  return primitive;
}

Mesh posed(const GltfPrimitive& primitive, std::span<const double> weights, std::span<const glm::dmat4> joints,
           const Material& material) {
  Mesh mesh = primitive.mesh;
  apply_targets(primitive, weights, mesh);
  if (!joints.empty()) apply_skin(primitive, joints, mesh);
  const bool has_uvs = !mesh.uvs.empty();
  if (!has_uvs) mesh.uvs.assign(mesh.positions.size(), glm::dvec2(0));
  // Section 3.7.2.1: without normals, flat ones.
  const auto is_given = [](const glm::dvec3& n) { return glm::length(n) > 0 && std::isfinite(glm::length(n)); };
  if (std::ranges::any_of(mesh.normals, is_given)) {
    make_missing_normals(mesh);
  } else {
    make_flat_normals(mesh);
  }
  if (material.normal_texture == kNone || !has_uvs) {
    mesh.tangents.clear();
  } else if (mesh.tangents.empty()) {
    make_tangents(mesh, material.normal_uv);
  } else {
    for (glm::dvec4& tangent : mesh.tangents) {
      const double length = glm::length(glm::dvec3(tangent));
      tangent = length > 0 && std::isfinite(length) ? glm::dvec4(glm::dvec3(tangent) / length, tangent.w)
                                                    : glm::dvec4(0, 0, 0, 1);
    }
  }
  return mesh;
}

}  // namespace subpixel::capture
