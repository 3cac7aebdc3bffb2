#include "replay/reference/triangle_list.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace subpixel::replay {
namespace {

// Corners counted by 32 bits, and three of them a triangle.
constexpr std::size_t kMostTriangles = std::numeric_limits<std::uint32_t>::max() / 3 - 1;

// World to clip of one instance, rows, for points with w 1.
struct ClipRows {
  glm::dvec4 x, y, z, w;
  glm::dvec4 operator()(const glm::dvec3& p) const {
    const glm::dvec4 point(p, 1);
    return {glm::dot(x, point), glm::dot(y, point), glm::dot(z, point), glm::dot(w, point)};
  }
};

ClipRows clip_rows(const gpu_types::FrameConstants& frame, const gpu_types::InstanceRecord& instance) {
  glm::dmat4 world(1);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) world[c][r] = instance.world_row[r][c];
  const glm::dmat4 rows = glm::transpose(glm::dmat4(frame.view_projection) * world);
  return {rows[0], rows[1], rows[2], rows[3]};
}

// The planes of the view, x and y widened by `margin`, that `p` is outside of. Not finite: outside of all.
std::uint32_t outside(const glm::dvec4& p, const glm::dvec2& margin) {
  const glm::dvec2 reach = p.w * margin;
  const double sum = p.x + p.y + p.z + p.w;
  if (!(std::abs(sum) <= static_cast<double>(std::numeric_limits<float>::max()))) return 63;
  return (p.x < -reach.x ? 1u : 0u) | (p.x > reach.x ? 2u : 0u) | (p.y < -reach.y ? 4u : 0u) |
         (p.y > reach.y ? 8u : 0u) | (p.z < 0 ? 16u : 0u) | (p.z > p.w ? 32u : 0u);
}

// Positive when the corners run counter-clockwise on a screen whose y points up.
double orientation(const glm::dvec4& a, const glm::dvec4& b, const glm::dvec4& c) {
  return -(a.x * (b.y * c.w - b.w * c.y) - a.y * (b.x * c.w - b.w * c.x) + a.w * (b.x * c.y - b.y * c.x));
}

}  // namespace

TriangleList visible_triangles(const GpuScene& scene) {
  TriangleList list;
  const auto& frame = scene.constants();
  const auto positions = scene.positions.as<float>();
  const auto indices = scene.indices.as<std::uint32_t>();
  const auto instances = scene.instances.as<gpu_types::InstanceRecord>();
  const glm::dvec2 margin(1.0 + 4.0 * frame.viewport.z, 1.0 + 4.0 * frame.viewport.w);
  const auto position = [&](std::uint32_t vertex) {
    const std::size_t at = std::size_t{vertex} * 3;
    return glm::dvec3(positions[at], positions[at + 1], positions[at + 2]);
  };

  for (const auto& draw : scene.draws()) {
    const bool tested = scene.alpha_tested(draw.material), two_sided = scene.two_sided(draw.material);
    if (list.runs.empty() || list.runs.back().tested != tested)
      list.runs.push_back({tested, static_cast<std::uint32_t>(list.triangles.size()), 0});
    for (std::uint32_t i = 0; i < draw.instance_count; ++i) {
      const std::uint32_t instance = draw.first_instance + i;
      const ClipRows to_clip = clip_rows(frame, instances[instance]);
      const double winding = instances[instance].normal_row[0].w;
      for (std::uint32_t t = 0; t < draw.triangle_count; ++t) {
        const std::uint32_t first_index = draw.first_index + 3 * t;
        glm::dvec4 corner[3];
        std::uint32_t all_outside = 63;
        for (std::uint32_t c = 0; c < 3; ++c) {
          corner[c] = to_clip(position(indices[first_index + c]));
          const std::uint32_t sides = outside(corner[c], margin);
          if (sides == 63) all_outside |= 64;
          all_outside &= sides | 64;
        }
        if (all_outside != 0) continue;
        const double facing = orientation(corner[0], corner[1], corner[2]) * winding;
        if (facing == 0 || (facing < 0 && !two_sided)) continue;
        for (const auto& c : corner) list.corners.emplace_back(c);
        list.triangles.push_back({{first_index, instance, draw.material, facing < 0 ? REFERENCE_BACK_FACE : 0u}});
        ++list.runs.back().count;
      }
    }
    if (list.triangles.size() > kMostTriangles)
      throw DeviceError("reference",
                        fmt::format("{} visible triangles are over {}", list.triangles.size(), kMostTriangles),
                        "triangle list");
  }
  return list;
}

}  // namespace subpixel::replay
