// Triangle meshes made by us: by the generators, and the ground of imported scenes. In metres, +y up.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace subpixel::capture {

// Front faces are counter-clockwise seen from outside. All others are empty or one for each position.
struct Mesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::dvec3> normals;
  std::vector<glm::dvec2> uvs;
  std::vector<glm::dvec4> tangents;
  std::vector<glm::dvec2> uvs2;
  std::vector<glm::vec4> colours;  // linear
  std::vector<std::uint32_t> indices;

  std::uint32_t add_vertex(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec2& uv);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  std::size_t triangle_count() const { return indices.size() / 3; }
};

// Adds `part` placed by `transform`, whose linear part must be a rotation with uniform scale.
void append(Mesh& mesh, const Mesh& part, const glm::dmat4& transform);

// A parallelogram: corner, corner + right, corner + up, facing cross(right, up); uv in metres times uv_scale.
void add_quad(Mesh& mesh, const glm::dvec3& corner, const glm::dvec3& right, const glm::dvec3& up, double uv_scale = 1);

// A box with sharp edges; uv in metres times uv_scale on each face, v upwards on upright ones.
void add_box(Mesh& mesh, const glm::dvec3& low, const glm::dvec3& high, double uv_scale = 1);

// A tube of `sides` along a path of at least two points with one radius each, smooth across the sides, ends open or
// closed by fans. uv: u once around, v the length so far in metres.
void add_tube(Mesh& mesh, std::span<const glm::dvec3> path, std::span<const double> radii, std::uint32_t sides,
              bool closed_ends);

// A straight tube of one radius.
void add_bar(Mesh& mesh, const glm::dvec3& from, const glm::dvec3& to, double radius, std::uint32_t sides,
             bool closed_ends = true);

// A sphere of rings x 2 rings quads with one pole triangle fan each.
void add_sphere(Mesh& mesh, const glm::dvec3& centre, double radius, std::uint32_t rings);

// Tangents from positions and uvs (Lengyel's method), orthogonal to the normals, with the bitangent's sign in w.
void compute_tangents(Mesh& mesh);

}  // namespace subpixel::capture
