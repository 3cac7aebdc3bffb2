#include "scenes/builder/mesh.hpp"

#include <array>
#include <cassert>
#include <glm/geometric.hpp>

#include "scenes/builder/camera.hpp"

namespace subpixel::capture {
namespace {

glm::dvec3 any_perpendicular(const glm::dvec3& direction) {
  const glm::dvec3 other = direction.x * direction.x < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, other));
}

}  // namespace

std::uint32_t Mesh::add_vertex(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec2& uv) {
  positions.push_back(position);
  normals.push_back(normal);
  uvs.push_back(uv);
  return static_cast<std::uint32_t>(positions.size() - 1);
}

void Mesh::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  indices.insert(indices.end(), {a, b, c});
}

void append(Mesh& mesh, const Mesh& part, const glm::dmat4& transform) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    mesh.add_vertex(glm::dvec3(transform * glm::dvec4(part.positions[i], 1)),
                    glm::normalize(glm::dvec3(transform * glm::dvec4(part.normals[i], 0))), part.uvs[i]);
  }
  for (const std::uint32_t index : part.indices) mesh.indices.push_back(first + index);
}

void add_quad(Mesh& mesh, const glm::dvec3& corner, const glm::dvec3& right, const glm::dvec3& up, double uv_scale) {
  const glm::dvec3 normal = glm::normalize(glm::cross(right, up));
  const double u = glm::length(right) * uv_scale;
  const double v = glm::length(up) * uv_scale;
  const std::uint32_t a = mesh.add_vertex(corner, normal, {0, v});  // v = 0 is the image's top row
  const std::uint32_t b = mesh.add_vertex(corner + right, normal, {u, v});
  const std::uint32_t c = mesh.add_vertex(corner + right + up, normal, {u, 0});
  const std::uint32_t d = mesh.add_vertex(corner + up, normal, {0, 0});
  mesh.add_triangle(a, b, c);
  mesh.add_triangle(a, c, d);
}

void add_box(Mesh& mesh, const glm::dvec3& low, const glm::dvec3& high, double uv_scale) {
  const glm::dvec3 size = high - low;
  const glm::dvec3 x(size.x, 0, 0);
  const glm::dvec3 y(0, size.y, 0);
  const glm::dvec3 z(0, 0, size.z);
  add_quad(mesh, low + z, x, y, uv_scale);       // front, +z
  add_quad(mesh, low + x, -x, y, uv_scale);      // back, -z
  add_quad(mesh, low + x + z, -z, y, uv_scale);  // right, +x
  add_quad(mesh, low, z, y, uv_scale);           // left, -x
  add_quad(mesh, low + y + z, x, -z, uv_scale);  // top, +y
  add_quad(mesh, low, x, z, uv_scale);           // bottom, -y
}

void add_tube(Mesh& mesh, std::span<const glm::dvec3> path, std::span<const double> radii, std::uint32_t sides,
              bool closed_ends) {
  assert(path.size() >= 2 && path.size() == radii.size() && sides >= 3);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const std::uint32_t ring = sides + 1;  // the seam's vertices are there twice, for u = 0 and u = 1
  glm::dvec3 across = any_perpendicular(glm::normalize(path[1] - path[0]));
  double length = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const glm::dvec3 along = glm::normalize(path[i + 1 < path.size() ? i + 1 : i] - path[i > 0 ? i - 1 : 0]);
    across = glm::normalize(across - along * glm::dot(across, along));  // carried along, so that the tube never twists
    const glm::dvec3 other = glm::cross(along, across);
    if (i > 0) length += glm::length(path[i] - path[i - 1]);
    for (std::uint32_t s = 0; s <= sides; ++s) {
      const double angle = 2 * kPi * (s % sides) / sides;  // % makes the seam's positions equal to the bit
      const glm::dvec3 normal = across * cosine(angle) + other * sine(angle);
      mesh.add_vertex(path[i] + normal * radii[i], normal, {static_cast<double>(s) / sides, length});
    }
  }
  const auto rings = static_cast<std::uint32_t>(path.size());
  for (std::uint32_t i = 0; i + 1 < rings; ++i) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const std::uint32_t a = first + i * ring + s;
      mesh.add_triangle(a, a + 1, a + ring + 1);
      mesh.add_triangle(a, a + ring + 1, a + ring);
    }
  }
  if (!closed_ends) return;
  for (const bool at_end : {false, true}) {
    const std::size_t i = at_end ? path.size() - 1 : 0;
    const glm::dvec3 outward = glm::normalize(at_end ? path[i] - path[i - 1] : path[0] - path[1]);
    const std::uint32_t centre = mesh.add_vertex(path[i], outward, {0.5, 0.5});
    const std::uint32_t rim = centre + 1;
    for (std::uint32_t s = 0; s < sides; ++s) {
      mesh.add_vertex(mesh.positions[first + i * ring + s], outward, {0.5, 0.5});
    }
    for (std::uint32_t s = 0; s < sides; ++s) {
      const std::uint32_t next = rim + (s + 1) % sides;
      if (at_end) {
        mesh.add_triangle(centre, rim + s, next);
      } else {
        mesh.add_triangle(centre, next, rim + s);
      }
    }
  }
}

void add_bar(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double radius, std::uint32_t sides,
             bool closed_ends) {
  add_tube(mesh, std::array{from, to}, std::array{radius, radius}, sides, closed_ends);
}

void add_sphere(Mesh& mesh, const glm::dvec3& centre, double radius, std::uint32_t rings) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const std::uint32_t around = 2 * rings;
  for (std::uint32_t r = 0; r <= rings; ++r) {
    const double polar = kPi * r / rings;
    const double height = r == 0 ? 1 : r == rings ? -1 : cosine(polar);
    const double girth = r == 0 || r == rings ? 0 : sine(polar);
    for (std::uint32_t s = 0; s <= around; ++s) {
      const double angle = 2 * kPi * (s % around) / around;
      const glm::dvec3 normal(girth * sine(angle), height, girth * cosine(angle));
      mesh.add_vertex(centre + normal * radius, normal,
                      {static_cast<double>(s) / around, static_cast<double>(r) / rings});
    }
  }
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < around; ++s) {
      const std::uint32_t a = first + r * (around + 1) + s;
      const std::uint32_t below = a + around + 1;
      if (r > 0) mesh.add_triangle(a, below, a + 1);
      if (r + 1 < rings) mesh.add_triangle(a + 1, below, below + 1);
    }
  }
}

void compute_tangents(Mesh& mesh) {
  std::vector<glm::dvec3> along_u(mesh.positions.size(), glm::dvec3(0));
  std::vector<glm::dvec3> along_v(mesh.positions.size(), glm::dvec3(0));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::array corner{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    const glm::dvec3 e1 = mesh.positions[corner[1]] - mesh.positions[corner[0]];
    const glm::dvec3 e2 = mesh.positions[corner[2]] - mesh.positions[corner[0]];
    const glm::dvec2 d1 = mesh.uvs[corner[1]] - mesh.uvs[corner[0]];
    const glm::dvec2 d2 = mesh.uvs[corner[2]] - mesh.uvs[corner[0]];
    const double area = d1.x * d2.y - d2.x * d1.y;
    if (area == 0) continue;
    for (const std::uint32_t c : corner) {
      along_u[c] += (e1 * d2.y - e2 * d1.y) / area;
      along_v[c] += (e2 * d1.x - e1 * d2.x) / area;
    }
  }
  mesh.tangents.resize(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dvec3& normal = mesh.normals[i];
    const glm::dvec3 tangent = along_u[i] - normal * glm::dot(normal, along_u[i]);
    const double length = glm::length(tangent);
    const glm::dvec3 unit = length > 0 ? tangent / length : any_perpendicular(normal);
    // v grows down the image while a normal map's +Y is up it, hence the bitangent is against along_v.
    const double sign = glm::dot(glm::cross(normal, unit), along_v[i]) > 0 ? -1.0 : 1.0;
    mesh.tangents[i] = glm::dvec4(unit, sign);
  }
}

}  // namespace subpixel::capture
