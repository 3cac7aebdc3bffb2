#include "replay/scene/tangents.hpp"

#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>

namespace subpixel::replay {
namespace {

glm::dvec3 vec3_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

bool usable(const glm::dvec3& v) {
  const double length_squared = glm::dot(v, v);
  return length_squared > 1e-60 && length_squared < 1e60;
}

}  // namespace

std::vector<float> tangents_from_uvs(const std::vector<float>& positions, const std::vector<float>& normals,
                                     const std::vector<float>& uvs, const std::vector<std::uint32_t>& triangles) {
  const std::size_t vertex_count = positions.size() / 3;
  std::vector<glm::dvec3> along_u(vertex_count), along_v(vertex_count);
  for (std::size_t t = 0; t + 3 <= triangles.size(); t += 3) {
    const std::size_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    const glm::dvec3 e1 = vec3_at(positions, b) - vec3_at(positions, a);
    const glm::dvec3 e2 = vec3_at(positions, c) - vec3_at(positions, a);
    const double u1 = double{uvs[2 * b]} - uvs[2 * a], v1 = double{uvs[2 * b + 1]} - uvs[2 * a + 1];
    const double u2 = double{uvs[2 * c]} - uvs[2 * a], v2 = double{uvs[2 * c + 1]} - uvs[2 * a + 1];
    const double determinant = u1 * v2 - u2 * v1;
    if (determinant == 0) continue;
    const double sign = determinant < 0 ? -1 : 1;
    glm::dvec3 tangent = (e1 * v2 - e2 * v1) * sign, bitangent = (e2 * u1 - e1 * u2) * sign;
    if (!usable(tangent) || !usable(bitangent)) continue;
    const double area = glm::length(glm::cross(e1, e2));
    tangent *= area / glm::length(tangent);
    bitangent *= area / glm::length(bitangent);
    for (const std::size_t corner : {a, b, c}) {
      along_u[corner] += tangent;
      along_v[corner] += bitangent;
    }
  }
  std::vector<float> tangents(4 * vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const glm::dvec3 normal = vec3_at(normals, i);
    const glm::dvec3 tangent = along_u[i] - normal * glm::dot(normal, along_u[i]);
    if (!usable(tangent)) continue;
    const glm::dvec3 direction = glm::normalize(tangent);
    for (int c = 0; c < 3; ++c) tangents[4 * i + static_cast<std::size_t>(c)] = static_cast<float>(direction[c]);
    // Texture v grows down the image while the map's +Y is up, so the bitangent is against growing v.
    tangents[4 * i + 3] = glm::dot(glm::cross(normal, direction), along_v[i]) > 0 ? -1.0f : 1.0f;
  }
  return tangents;
}

}  // namespace subpixel::replay
