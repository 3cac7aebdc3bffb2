// A captured frame's camera in the replay's conventions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "capture_format/capture.hpp"
#include "replay/scene/bounds.hpp"

namespace subpixel::replay {

// All in double: inverses of reversed-depth projections lose too much in float.
struct Camera {
  glm::dmat4 view{1}, view_projection{1}, inverse_view_projection{1};
  glm::dvec3 eye{0};
};

glm::dmat4 matrix(const capture::Matrix4& column_major);

// View and projection converted to Vulkan clip space (y down the image, z from 0 far to 1 near). Throws InputError
// naming the frame when a matrix is not finite or can't be inverted.
Camera camera_of(const capture::Frame& frame, std::uint32_t index);

// In clip space: what moves an image of `size` pixels by `pixels` to the right and down.
glm::dmat4 moved_image(const glm::dvec2& pixels, const glm::dvec2& size);

// Points p with dot(normal, p) + offset >= 0; the normal is unit.
struct HalfSpace {
  glm::dvec3 normal{0};
  double offset = 0;
  double distance(const glm::dvec3& p) const { return glm::dot(normal, p) + offset; }
};

// The part of `bounds` that the camera sees, and that is in `part`, as corner points of the common volume; empty when
// nothing is seen.
std::vector<glm::dvec3> visible_corners(const Camera& camera, const Bounds& bounds,
                                        const std::optional<HalfSpace>& part = std::nullopt);

}  // namespace subpixel::replay
