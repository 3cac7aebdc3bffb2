// The triangles of a frame that may be seen, in submission order, in clip space.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "replay/scene/gpu_scene.hpp"
#include "shaders/reference/reference_interface.h"

namespace subpixel::replay {

// Triangles [first, first + count) of the list: drawn by one call.
struct TriangleRun {
  bool tested = false;  // alpha decides which samples are there
  std::uint32_t first = 0, count = 0;
};

struct TriangleList {
  std::vector<glm::vec4> corners;  // three a triangle, homogeneous clip positions
  std::vector<gpu_types::ReferenceTriangle> triangles;
  std::vector<TriangleRun> runs;  // all of them, in order
};

// Leaves out what no sample can see: triangles with a corner that is not finite, beside the view (a pixel's width
// further, since the image is shifted), without area, and back faces of one-sided materials. The front
// is counter-clockwise in world space, under a mirroring transform clockwise in object space (glTF). Transforms are
// computed in double and rounded once. Throws DeviceError when triangle numbers exceed what one draw call counts.
TriangleList visible_triangles(const GpuScene& scene);

}  // namespace subpixel::replay
