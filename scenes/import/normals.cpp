#include "scenes/import/normals.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>
#include <unordered_map>

#include "scenes/builder/camera.hpp"

namespace subpixel::capture {
namespace {

constexpr glm::dvec3 kUp{0, 1, 0};  // of vertices that no triangle with an area uses

// Length 1, or 0 where there is no direction. Scaled first: the squares of very small and very large numbers vanish.
glm::dvec3 unit_or_zero(const glm::dvec3& vector) {
  const double largest = std::max({std::abs(vector.x), std::abs(vector.y), std::abs(vector.z)});
  if (!std::isfinite(vector.x + vector.y + vector.z) || !(largest > 0)) return {0, 0, 0};
  return glm::normalize(vector / largest);
}

bool is_zero(const glm::dvec3& vector) {
  return vector == glm::dvec3(0);
}

// A vertex number and three coordinates, or three coordinates alone: keys whose equality is that of numbers.
using VertexKey = std::array<std::uint64_t, 4>;

VertexKey key_of(std::uint64_t number, const glm::dvec3& v) {
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value); };  // -0 is 0
  return {number, bits(v.x), bits(v.y), bits(v.z)};
}

struct KeyHash {
  std::size_t operator()(const VertexKey& key) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t part : key) {  // the finaliser of SplitMix64 (Steele et al. 2014) on each part
      hash += part + 0x9e3779b97f4a7c15u;
      hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
      hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
      hash ^= hash >> 31;
    }
    return hash;
  }
};

void repeat_vertex(Mesh& mesh, std::uint32_t vertex) {
  const auto repeat = [vertex](auto& list) {
    if (!list.empty()) list.push_back(list[vertex]);
  };
  repeat(mesh.positions);
  repeat(mesh.normals);
  repeat(mesh.uvs);
  repeat(mesh.tangents);
  repeat(mesh.uvs2);
  repeat(mesh.colours);
}

// Each corner of the index list gets its normal; a zero one takes what its vertex has, or gets.
std::vector<std::uint32_t> set_corner_normals(Mesh& mesh, const std::vector<glm::dvec3>& corner_normals) {
  mesh.normals.resize(mesh.positions.size(), glm::dvec3(0));
  std::vector<std::uint32_t> sources(mesh.positions.size());
  std::iota(sources.begin(), sources.end(), 0u);
  std::vector<bool> taken(mesh.positions.size(), false);
  constexpr double kSteps = 1 << 20;  // triangles of one polygon are in one plane but for rounding
  std::unordered_map<VertexKey, std::uint32_t, KeyHash> copies;
  for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner) {
    const glm::dvec3& normal = corner_normals[corner];
    if (is_zero(normal)) continue;
    std::uint32_t& vertex = mesh.indices[corner];
    const auto [copy, is_new] = copies.try_emplace(key_of(vertex, glm::round(normal * kSteps)),
                                                   static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new && !taken[vertex]) {
      taken[vertex] = true;
      copy->second = vertex;
      mesh.normals[vertex] = normal;
    } else if (is_new) {
      repeat_vertex(mesh, vertex);
      mesh.normals.back() = normal;
      sources.push_back(vertex);
    }
    vertex = copy->second;
  }
  for (glm::dvec3& normal : mesh.normals) {
    if (is_zero(normal)) normal = kUp;
  }
  return sources;
}

std::vector<glm::dvec3> triangle_normals(const Mesh& mesh) {
  std::vector<glm::dvec3> normals(mesh.triangle_count());
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const glm::dvec3& a = mesh.positions[mesh.indices[3 * t]];
    const glm::dvec3& b = mesh.positions[mesh.indices[3 * t + 1]];
    const glm::dvec3& c = mesh.positions[mesh.indices[3 * t + 2]];
    normals[t] = unit_or_zero(glm::cross(unit_or_zero(b - a), unit_or_zero(c - a)));
  }
  return normals;
}

double angle_at_corner(const Mesh& mesh, std::size_t corner) {
  const std::size_t first = corner / 3 * 3;
  const glm::dvec3& at = mesh.positions[mesh.indices[corner]];
  const glm::dvec3 next = unit_or_zero(mesh.positions[mesh.indices[first + (corner + 1) % 3]] - at);
  const glm::dvec3 previous = unit_or_zero(mesh.positions[mesh.indices[first + (corner + 2) % 3]] - at);
  return std::acos(std::clamp(glm::dot(next, previous), -1.0, 1.0));
}

// The corners around each position that share a normal, as a forest with path halving.
class SmoothCorners {
 public:
  explicit SmoothCorners(std::size_t corners) : parents_(corners) { std::iota(parents_.begin(), parents_.end(), 0u); }

  std::uint32_t find(std::uint32_t corner) {
    while (parents_[corner] != corner) corner = parents_[corner] = parents_[parents_[corner]];
    return corner;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t root_a = find(a), root_b = find(b);
    parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }

 private:
  std::vector<std::uint32_t> parents_;
};

// One side of a triangle: from `corner` to the triangle's next one, between two positions by number.
struct Side {
  std::uint32_t low, high;  // positions
  std::uint32_t low_corner, high_corner;
};

std::vector<Side> sorted_sides(const Mesh& mesh) {
  std::unordered_map<VertexKey, std::uint32_t, KeyHash> numbers;
  std::vector<std::uint32_t> position(mesh.positions.size());
  for (std::uint32_t v = 0; v < position.size(); ++v) {
    position[v] = numbers.try_emplace(key_of(0, mesh.positions[v]), v).first->second;
  }
  std::vector<Side> sides;
  sides.reserve(mesh.indices.size());
  for (std::uint32_t corner = 0; corner < mesh.indices.size(); ++corner) {
    const std::uint32_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
    const std::uint32_t a = position[mesh.indices[corner]], b = position[mesh.indices[next]];
    if (a == b) continue;
    sides.push_back(a < b ? Side{a, b, corner, next} : Side{b, a, next, corner});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.low_corner) < std::tie(b.low, b.high, b.low_corner);
  });
  return sides;
}

SmoothCorners join_smooth_corners(const Mesh& mesh, const std::vector<glm::dvec3>& faces,
                                  std::span<const SmoothingGroup> groups) {
  // Sides at one edge that are compared with each other: leaves seen from both sides have 4, and a file in which
  // thousands meet must not cost their square.
  constexpr std::size_t kMostAtEdge = 8;
  const double crease_cosine = cosine(kCreaseDegrees * kPi / 180);
  const double group_cosine = cosine(kGroupCreaseDegrees * kPi / 180);
  const auto group_of = [&](std::uint32_t triangle) { return groups.empty() ? kByCreaseAngle : groups[triangle]; };
  const auto is_smooth = [&](std::uint32_t t, std::uint32_t u) {
    if (is_zero(faces[t]) || is_zero(faces[u]) || group_of(t) != group_of(u)) return false;
    if (group_of(t) == 0) return false;
    return glm::dot(faces[t], faces[u]) >= (group_of(t) == kByCreaseAngle ? crease_cosine : group_cosine);
  };
  SmoothCorners corners(mesh.indices.size());
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Side& side = sides[i];
    for (std::size_t j = i + 1; j < std::min(sides.size(), i + kMostAtEdge); ++j) {
      const Side& other = sides[j];
      if (other.low != side.low || other.high != side.high) break;
      if (!is_smooth(side.low_corner / 3, other.low_corner / 3)) continue;
      corners.join(side.low_corner, other.low_corner);
      corners.join(side.high_corner, other.high_corner);
    }
  }
  return corners;
}

}  // namespace

std::vector<std::uint32_t> make_flat_normals(Mesh& mesh) {
  const std::vector<glm::dvec3> faces = triangle_normals(mesh);
  std::vector<glm::dvec3> corner_normals(mesh.indices.size());
  for (std::size_t corner = 0; corner < corner_normals.size(); ++corner) corner_normals[corner] = faces[corner / 3];
  mesh.normals.clear();
  return set_corner_normals(mesh, corner_normals);
}

std::vector<std::uint32_t> make_missing_normals(Mesh& mesh, std::span<const SmoothingGroup> groups) {
  mesh.normals.resize(mesh.positions.size(), glm::dvec3(0));
  for (glm::dvec3& normal : mesh.normals) normal = unit_or_zero(normal);
  std::vector<glm::dvec3> corner_normals(mesh.indices.size(), glm::dvec3(0));
  const auto lacks = [&](std::size_t corner) { return is_zero(mesh.normals[mesh.indices[corner]]); };
  const bool any_lacks = std::any_of(mesh.indices.begin(), mesh.indices.end(),
                                     [&](std::uint32_t vertex) { return is_zero(mesh.normals[vertex]); });
  if (any_lacks) {
    const std::vector<glm::dvec3> faces = triangle_normals(mesh);
    SmoothCorners smooth = join_smooth_corners(mesh, faces, groups);
    std::vector<glm::dvec3> sums(mesh.indices.size(), glm::dvec3(0));
    for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
      sums[smooth.find(corner)] += faces[corner / 3] * angle_at_corner(mesh, corner);
    }
    for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
      if (!lacks(corner)) continue;
      const glm::dvec3 normal = unit_or_zero(sums[smooth.find(corner)]);
      corner_normals[corner] = is_zero(normal) ? faces[corner / 3] : normal;
    }
  }
  return set_corner_normals(mesh, corner_normals);
}

}  // namespace subpixel::capture
